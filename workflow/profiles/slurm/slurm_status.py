#!/usr/bin/python3
"""slurm_status.py JOB: prints running, success or failed, as Snakemake asks for. Needs no accounting database."""
import re
import subprocess
import sys

job = sys.argv[1]
shown = subprocess.run(["scontrol", "--oneliner", "show", "job", job], capture_output=True, text=True)
state = re.search(r"\bJobState=(\w+)", shown.stdout)
if not state:  # the controller has forgotten it; the database may know
    shown = subprocess.run(["sacct", "--noheader", "--parsable2", "--format=State", "--jobs", job], capture_output=True,
                           text=True)
    state = re.match(r"(\w+)", shown.stdout)
word = state[1] if state else "LOST"
if word == "COMPLETED":
    print("success")
elif word in ("PENDING", "RUNNING", "CONFIGURING", "COMPLETING", "SUSPENDED", "REQUEUED", "RESIZING", "STAGE_OUT"):
    print("running")
else:
    print("failed")
