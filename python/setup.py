"""Puts the library's header into the package, which declares the library to Python by it."""
import re
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

HEADER = Path(__file__).resolve().parents[1] / "include" / "softlux.h"


class BuildWithHeader(build_py):
    def run(self):
        super().run()
        self.copy_file(str(HEADER), str(Path(self.build_lib) / "softlux" / "softlux.h"))


setup(
    version=re.search(r'#define SL_VERSION "(.*)"', HEADER.read_text(encoding="utf-8"))[1],
    cmdclass={"build_py": BuildWithHeader},
)
