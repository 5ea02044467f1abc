# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the tests; with `bpy`, those in Blender too. Arguments: patterns of test files.

python run.py                 all
python run.py test_motion.py  one file
"""

import faulthandler
import importlib.util
import os
import shutil
import sys
import tempfile
import unittest

SECONDS = 1800.0  # after this time, the run counts as hanging
HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)


def main(patterns):
    sys.path.insert(0, ROOT)
    faulthandler.dump_traceback_later(SECONDS, exit=True)
    tempfile.tempdir = tempfile.mkdtemp(prefix="slo-rt-test-")
    folders = ["pure"] + (["in_blender"] if importlib.util.find_spec("bpy") else [])
    suite = unittest.TestSuite()
    for folder in folders:
        for pattern in patterns or ["test_*.py"]:
            start = os.path.join(HERE, folder)
            suite.addTests(unittest.TestLoader().discover(start, pattern, ROOT))
    result = unittest.TextTestRunner(verbosity=1).run(suite)
    shutil.rmtree(tempfile.tempdir, ignore_errors=True)
    sys.stdout.flush()
    sys.stderr.flush()
    # The module bpy may hang while Python shuts down.
    os._exit(0 if result.wasSuccessful() else 1)


if __name__ == "__main__":
    main(sys.argv[1:])
