"""run_case.py STATUS.json COMMAND...: runs the command with --output beside STATUS.json and writes how it went.

What was printed is kept in log.txt. Exit status 0 unless the command was killed: then nothing is written, so that it is
done again.
"""
import json
import pathlib
import shutil
import subprocess
import sys
import time

status_file, command = pathlib.Path(sys.argv[1]), sys.argv[2:]
folder = status_file.parent
results = folder / "results"
shutil.rmtree(results, ignore_errors=True)  # of a run that was killed
folder.mkdir(parents=True, exist_ok=True)
start = time.monotonic()
with open(folder / "log.txt", "w") as log:
    done = subprocess.run([*command, "--output", str(results)], stdout=log, stderr=subprocess.STDOUT)
if done.returncode < 0 or done.returncode > 128:
    sys.exit(f"{command[0]} was killed; see {folder / 'log.txt'}")
messages = [line for line in (folder / "log.txt").read_text().splitlines() if line.startswith("livermark: ")]
files = sorted(str(file.relative_to(folder)) for file in results.glob("*/*.h5"))
# Status 1 has results too: a model left its band or did not converge, which the files say model by model.
status_file.write_text(json.dumps({
    "status": "ok" if files else "failed",
    "exit_status": done.returncode,
    "message": "" if files else " ".join(messages),
    "seconds": time.monotonic() - start,
    "files": files,
}, indent=1) + "\n")
