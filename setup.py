"""Builds the Python module from src/python, which finds or builds the C++ library (CMakeLists.txt there).

With CMAKE_ARGS="-Drecon_DIR=<prefix>/lib/cmake/recon" in the environment the module is built with a library that
is installed; without, the library is built with it, which takes some minutes.
"""

import os
import pathlib
import re
import shlex

from skbuild import setup

root = pathlib.Path(__file__).resolve().parent
version = re.search(r"project\(recon VERSION ([0-9.]+)", (root / "CMakeLists.txt").read_text())

setup(
    name="recon",
    version=version.group(1),
    description="Reproducing-kernel reconstruction of fields from scattered particles",
    license="see LICENSE",
    packages=["recon"],
    package_dir={"recon": "src/python/recon"},
    package_data={"recon": ["py.typed", "*.pyi"]},
    python_requires=">=3.9",
    install_requires=["numpy"],
    extras_require={"plot": ["matplotlib"], "sparse": ["scipy"]},
    cmake_source_dir="src/python",
    cmake_install_dir="src/python",
    cmake_install_target="install-python",
    cmake_args=shlex.split(os.environ.get("CMAKE_ARGS", "")),
)
