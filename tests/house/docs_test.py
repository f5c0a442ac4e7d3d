"""docs_test.py [<livermark>]: Markdown files of the tree lead where they say; with a program, what it makes of docs is true.

Without arguments this is the fast tier: no program is started but git, which knows the files.
"""
import importlib.machinery
import importlib.util
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
loader = importlib.machinery.SourceFileLoader("docs", str(ROOT / "scripts/docs"))
sys.dont_write_bytecode = True
docs = importlib.util.module_from_spec(importlib.util.spec_from_loader("docs", loader))
loader.exec_module(docs)
PROGRAM = pathlib.Path(sys.argv.pop()) if len(sys.argv) > 1 else None


def dead_links_of(pages):
    with tempfile.TemporaryDirectory() as folder:
        for name, text in pages.items():
            path = pathlib.Path(folder, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return docs.dead_links(pathlib.Path(folder))


class Examples(unittest.TestCase):
    def test_in_python_can_be_started_by_their_names(self):
        engines = ROOT / "examples" / "engines"
        scripts = [path for path in docs.files(ROOT) if ROOT / "examples" in path.parents and path.suffix == ".py"
                   and path != engines / "files.py"] + [engines / "compare"]
        self.assertGreater(len(scripts), 2)
        for path in scripts:
            self.assertRegex(path.read_text(), r"\A#!/usr/bin/(env )?python3\n\"\"\"", path.name)
            self.assertTrue(path.stat().st_mode & 0o100, f"{path.name} is not executable")


class Links(unittest.TestCase):
    def test_of_this_tree_lead_somewhere(self):
        self.assertGreater(len([path for path in docs.files(ROOT) if path.suffix == ".md"]), 20)
        self.assertEqual(docs.dead_links(ROOT), [])

    def test_that_lead_somewhere_are_not_named(self):
        other = "# A heading, with `code` and 2 words\n\n## Twice\n\n## Twice\n"
        page = ("# Top\n[a](other.md) [b](other.md#a-heading-with-code-and-2-words) [c](other.md#twice-1) [d](#top) "
                "[e](https://example.org/x) ![f](folder/picture.png)\n```sh\n[g](nowhere.md)\n```\n`[h](nowhere.md)`\n")
        self.assertEqual(dead_links_of({"page.md": page, "other.md": other, "folder/picture.png": ""}), [])

    def test_that_lead_nowhere_are_named(self):
        for target, why in {"nowhere.md": "there is no such file", "other.md#nowhere": "there is no heading for #nowhere",
                            "#nowhere": "there is no heading for #nowhere", "folder/": "is a folder",
                            "picture.png#top": "there is no heading for #top", "../../out.md": "leads out of the tree"}.items():
            lines = dead_links_of({"page.md": f"# Top\n[a]({target})\n", "other.md": "# Top\n", "folder/a.md": "", "picture.png": ""})
            self.assertEqual(len(lines), 1, (target, lines))
            self.assertIn(why, lines[0])
            self.assertIn("page.md", lines[0])

    def test_with_code_as_their_text_are_looked_at(self):
        page = "[`a`](nowhere.md) and `more code`; `code` and [`b` c](nowhere.md)\n"
        self.assertEqual(len(dead_links_of({"page.md": page})), 2)

    def test_in_notebooks_are_looked_at(self):
        notebook = '{"cells": [{"cell_type": "markdown", "source": ["[a](", "nowhere.md)"]}]}'
        self.assertEqual(len(dead_links_of({"page.ipynb": notebook})), 1)

    def test_paths_of_pages_in_sources_are_looked_at(self):
        page = "docs/" + "page.md"
        self.assertEqual(dead_links_of({"a.cpp": f"// see {page}\n", page: "# Top\n"}), [])
        self.assertEqual(dead_links_of({"a.cpp": f"// see {page}\n"}), [f"a.cpp: {page} is not there"])


class GeneratedParts(unittest.TestCase):
    @unittest.skipIf(PROGRAM is None, "no program is given")
    def test_are_what_the_program_says(self):
        self.assertGreaterEqual(len(docs.pages_with_generated_parts()), 3)
        done = subprocess.run([sys.executable, ROOT / "scripts/docs", "--check", PROGRAM], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    @unittest.skipIf(PROGRAM is None, "no program is given")
    def test_that_are_old_are_made_again(self):
        page = "before\n<!-- generated: livermark list integrators -->\nold\n<!-- end -->\nafter\n"
        new = docs.with_generated(page, PROGRAM)
        self.assertTrue(new.startswith("before\n") and new.endswith("<!-- end -->\nafter\n"), new)
        self.assertIn("| `symplectic_euler` | symplectic (semi-implicit) Euler", new)
        self.assertNotIn("old", new)
        self.assertEqual(docs.with_generated(new, PROGRAM), new)


class TablesOfEngines(unittest.TestCase):
    def entry(self, engine, **problem):
        known = {"body": "beam", "load_case": "bend", "kind": "rest", "regime": "small", "tetrahedra": 40, "relative_l2": None,
                 "stiffness_at_tool": None, "in_contact": None, "force": None, "reference": "fem", "reference_error": None,
                 "seconds_per_frame": None, "setup_seconds": None, "memory_bytes": None, "outcome": "ok", "message": ""}
        return {"engine": engine, "version": "1", "url": "", "machine": "a | b", "cannot": [], "settings": {"substeps": 2},
                "livermark": "0.1.0", "created": "2026-11-29T12:00:00Z", "problems": [known | problem]}

    def test_have_the_smallest_error_first_and_a_dash_for_what_is_not_known(self):
        entries = [self.entry("a", relative_l2=0.2, stiffness_at_tool=0.5), self.entry("b"), self.entry("c", relative_l2=0.1),
                   self.entry("d", relative_l2=0.1, regime="large"), self.entry("e", relative_l2=0.1, outcome="failed")]
        rows = docs.engine_scores(entries, "rest", "small").splitlines()[2:]
        self.assertEqual([row.split(" | ")[3] for row in rows], ["c", "a", "b"])
        self.assertIn("| 20.00 | +50.0 | - | fem | - | - |", rows[1])

    def test_of_motion_have_both_errors_and_the_frame(self):
        entry = self.entry("a", kind="motion", regime="large", in_contact=0.165, force=0.355, seconds_per_frame=0.0039)
        row = docs.engine_scores([entry], "motion", "motion").splitlines()[2]
        self.assertIn("| a | 16.50 | 35.5 | - | fem | 3.9 | - | - |", row)

    def test_name_settings_and_failures(self):
        self.assertIn("| a | 1 | substeps: 2 | a \\| b | - | 0.1.0, 2026-11-29 |", docs.engine_list([self.entry("a")]))
        failed = docs.engine_failures([self.entry("a", outcome="cannot", message="No tool.")])
        self.assertIn("| a | beam | bend | cannot | No tool. |", failed)


class PlacesOfLoadCases(unittest.TestCase):
    def test_have_a_row_for_each_selector(self):
        page = (ROOT / "docs/reference/load_cases.md").read_text()
        for selector in (ROOT / "load_cases/selectors").glob("*.cpp"):
            rows = [line for line in page.splitlines() if line.startswith("| `") and f"`{selector.stem} = " in line]
            self.assertTrue(rows, selector)
            for row in rows:
                self.assertRegex(row, r"\| !\[[^\]]+\]\(places/\w+\.png\) \|$")


class Site(unittest.TestCase):
    @unittest.skipIf(PROGRAM is None, "takes seconds, which the fast tier has not")
    @unittest.skipIf(shutil.which("mkdocs") is None, "there is no mkdocs (Debian package mkdocs)")
    def test_is_made_without_a_warning(self):
        done = subprocess.run([sys.executable, ROOT / "scripts/docs"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertTrue(pathlib.Path(done.stdout.strip()).is_file(), done.stdout)
        self.assertTrue((ROOT / "build/docs/html/docs/index.html").is_file())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
