"""The HTML report of a folder of result files, which `livermark report` makes. See docs/reference/commands.md."""
import os as _os

# Matplotlib reads settings from a file of the working directory, which may be a folder that somebody was sent.
_folder = _os.getcwd()
_os.chdir("/")
try:
    import matplotlib as _matplotlib  # noqa: F401
finally:
    _os.chdir(_folder)
