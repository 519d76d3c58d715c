#!/usr/bin/python3
"""`pliant plot` from a clone, where the program need not be built."""
import pathlib
import runpy
import sys

sys.argv[1:1] = ["plot"]
runpy.run_path(str(pathlib.Path(__file__).resolve().parents[1] / "src/python/pliant/start.py"), run_name="__main__")
