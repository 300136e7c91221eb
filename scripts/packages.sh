# Read by examples/run, tests/run, bench/run and .ci/run: installs the Debian packages that are missing.
#
#   need_compiler            a C++20 compiler; sets CXX where the default one is too old
#   need_build               what the library and the programs need
#   need_bench, need_peers   Google Benchmark; other programs to compare with, which may be missing
#   need_tests, need_ci      what the tests and the checks need beyond that
#   install_missing LOG      installs what the functions above found to be missing
#
# Nothing is done, and apt-get is not called, where all is there.

missing_packages=()

has_command() { command -v "$1" >/dev/null 2>&1; }

# need_package NAME...: Debian packages, asked from dpkg.
need_package() {
  local name
  for name in "$@"; do
    if ! has_command dpkg-query ||
       [ "$(dpkg-query -W -f='${db:Status-Status}' "$name" 2>/dev/null)" != installed ]; then
      missing_packages+=("$name")
    fi
  done
}

# need_command PACKAGE COMMAND...: the package, unless one of the commands is there.
need_command() {
  local package=$1 command
  shift
  for command in "$@"; do
    has_command "$command" && return
  done
  missing_packages+=("$package")
}

# Does this compiler know C++20 as recon uses it (g++ 12 or clang 14 with a standard library)?
compiler_works() {
  has_command "$1" && "$1" -std=c++20 -fsyntax-only -x c++ - >/dev/null 2>&1 <<'PROGRAM'
#include <concepts>
#include <span>
#if defined(__clang__)
#if __clang_major__ < 14
#error too old
#endif
#elif __GNUC__ < 12
#error too old
#endif
int main() {}
PROGRAM
}

# The compiler is the one in CXX, else c++, g++ or clang++, whichever is new enough first; else
# g++ is installed.
need_compiler() {
  local compiler
  if [ -n "${CXX:-}" ]; then return; fi
  if compiler_works c++; then return; fi
  for compiler in g++ g++-14 g++-13 g++-12 clang++ clang++-19 clang++-18 clang++-17 clang++-16 \
                  clang++-15 clang++-14; do
    if compiler_works "$compiler"; then
      export CXX=$compiler
      return
    fi
  done
  missing_packages+=(g++)
}

need_build() {
  need_compiler
  need_command cmake cmake
  need_command ninja-build ninja make
  need_package libeigen3-dev libboost-dev libnanoflann-dev zlib1g-dev libcli11-dev
  need_package libhdf5-dev libmuparser-dev libtomlplusplus-dev  # recon::mpm
}

need_pictures() {
  need_command gnuplot-nox gnuplot
  need_package fonts-dejavu-core
}

need_tests() {
  need_package libgtest-dev libgmock-dev python3-vtk9 python3-h5py  # readers of our files that are not ours
  need_package gfortran pybind11-dev python3-dev python3-numpy python3-scipy python3-pandas python3-matplotlib \
    python3-pytest python3-mypy python3-pip python3-venv python3-skbuild
}

need_bench() {
  need_package libbenchmark-dev
}

need_peers() {
  need_package python3-numpy python3-scipy python3-vtk9
}

need_ci() {
  need_package clang libomp-dev libclang-rt-14-dev clang-format-14 clang-tidy-14  # Debian 12's clang is 14
  need_command git git
  need_command doxygen doxygen  # the site
  need_package petsc-dev libopenmpi-dev openmpi-bin iproute2  # many machines, and a network between them
}

# The names in missing_packages are installed, quietly; what apt-get says goes to the file LOG. Where it
# cannot be done they are named, and the caller goes on: a build may not need them all.
install_missing() {
  local log=$1 as_root=()
  [ ${#missing_packages[@]} -eq 0 ] && return 0
  if ! has_command apt-get || ! has_command dpkg-query; then
    echo "This is not a Debian-like system. Needed, by Debian's names: ${missing_packages[*]}" >&2
    missing_packages=()
    return 0
  fi
  if [ "$(id -u)" -ne 0 ]; then
    if ! has_command sudo; then
      echo "Neither root nor sudo: cannot install ${missing_packages[*]}" >&2
      missing_packages=()
      return 0
    fi
    as_root=(sudo)
  fi
  echo "Installing with apt-get: ${missing_packages[*]}"
  local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q)
  if ! { "${apt[@]}" update &&
         "${apt[@]}" install -y --no-install-recommends "${missing_packages[@]}"; } >"$log" 2>&1; then
    tail -n 5 "$log" >&2
    echo "Could not install ${missing_packages[*]} (all of it: $log)" >&2
  fi
  missing_packages=()
}
