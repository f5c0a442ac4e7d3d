"""The one place where the version of Livermark is written. CMake and pip read it here."""
__version__ = "0.1.0"
