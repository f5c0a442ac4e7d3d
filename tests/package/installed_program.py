"""The program of an extracted Debian package, used in an empty folder without the source tree and without a compiler.
usage: installed_program.py ROOT FOLDER"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import urllib.request

root, folder = (pathlib.Path(argument).resolve() for argument in sys.argv[1:])
program = root / "usr/bin/livermark"
programs = folder / "bin"
programs.mkdir(parents=True)
for name in ("env", "python3"):
    (programs / name).symlink_to(shutil.which(name))
environment = {"PATH": str(programs), "HOME": str(folder), "PYTHONPATH": str(root / "usr/lib/python3/dist-packages")}
work = folder / "work"
work.mkdir()


def said_by(*words):
    done = subprocess.run([program, *words], cwd=work, env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"livermark {' '.join(words)}: status {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def expect(holds, what):
    if not holds:
        sys.exit(what)


expect("liver_tumours" in said_by("list", "bodies"), "the bodies are not installed")
said_by("run", "--static", "--body", "liver_tumours", "beam", "--load-case", "palpation", "beam_bend", "--model", "lloyd")
expect((work / "results/runs/liver_tumours/palpation.h5").exists(), "results are not in the working directory")
table = said_by("table")
expect("lloyd" in table and "fem_p2p1_refined" in table, f"a table without a model or without the stored reference:\n{table}")
report = work / said_by("report").strip().splitlines()[-1]
expect("<svg" in report.read_text(), "a report without figures")

if not (root / "usr/lib/livermark/app/viewer/dist/index.html").exists():
    print("the page was not built, so the installed program has none")
    sys.exit()
server = subprocess.Popen([program, "view", "results/runs", "--port", "0", "--no-browser"], cwd=work, env=environment, stdout=subprocess.PIPE, text=True)
try:
    address = next(match[0] for line in server.stdout if (match := re.search(r"http://127\.0\.0\.1:\S+", line)))
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    page = opener.open(address).read()
    expect(b"<title>" in page and len(page) > 1_000_000, "the page is not the built one")
finally:
    server.terminate()
    server.wait()
print(f"the installed program makes tables, a report and the page in {os.fspath(work)}")
