"""The C library as its header declares it: `lib` has the functions and constants, `ffi` the types."""
import os
import re
from pathlib import Path

from cffi import FFI


def read_header():
    """Reads softlux.h: the package's own, or, in the source tree, the one in include/."""
    here = Path(__file__).resolve().parent
    own = here / "softlux.h"
    return (own if own.exists() else here.parents[1] / "include" / "softlux.h").read_text(encoding="utf-8")


def declarations(header):
    """Takes comments, C++ and the preprocessor's lines out of a header."""
    header = re.sub(r"/\*.*?\*/", "", header, flags=re.DOTALL)
    header = re.sub(r"^#ifdef __cplusplus$.*?^#endif$", "", header, flags=re.DOTALL | re.MULTILINE)
    return re.sub(r"^#.*$", "", header, flags=re.MULTILINE).replace("SL_API ", "")


def _numbers(version):
    return [int(n) for n in version.split(".")]


def _load(header):
    version = re.search(r'#define SL_VERSION "(.*)"', header)[1]
    name = os.environ.get("SOFTLUX_LIBRARY") or f"libsoftlux.so.{_numbers(version)[0]}"
    try:
        library = ffi.dlopen(name)
    except OSError as why:
        raise ImportError(f"{why}; the environment's SOFTLUX_LIBRARY may say where it is") from None
    found = ffi.string(library.sl_version()).decode()
    if _numbers(found) < _numbers(version):
        raise ImportError(f"{name} is version {found}, older than this package, {version}")
    return library


ffi = FFI()
ffi.cdef(declarations(read_header()))
lib = _load(read_header())
