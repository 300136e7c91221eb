# Read by examples/run, tests/run, bench/run and .ci/run, after packages.sh and in the root of the source tree:
# configures, builds and tests one of the presets of CMakePresets.json.
#
#   step "what is being done" LOG command...   one line of progress; the log only where it fails
#   build_preset PRESET [target...]            into build/PRESET; all that is built by default, or the targets
#   test_preset PRESET [ctest arguments]       ctest, with the exit status of ctest
#   leak_detection_works                       of clang's address sanitizer, here

jobs=$(nproc 2>/dev/null || echo 2)

step() {
  local title=$1 log=$2 begin=$SECONDS
  shift 2
  printf '%s ... ' "$title"
  if "$@" >"$log" 2>&1; then
    echo "$((SECONDS - begin)) s"
  else
    echo "failed"
    grep -m 5 -E '(^| )error: |CMake Error|undefined reference' "$log" >&2 || true  # may lie far above the end
    echo "..." >&2
    tail -n 40 "$log" >&2
    echo "Failed: $title. All of it: $log" >&2
    return 1
  fi
}

# Ninja and ccache are used where they are and nothing else was chosen. What is built for the first time is configured
# with configure_options, an array that a script may set.
configure_options=()
build_preset() {
  local preset=$1 dir=build/$1 targets=() options=()
  shift
  if [ $# -gt 0 ]; then targets=(--target "$@"); fi
  mkdir -p "$dir"
  if [ ! -f "$dir/CMakeCache.txt" ]; then
    options=("${configure_options[@]}")
    if [ -z "${CMAKE_GENERATOR:-}" ] && has_command ninja; then export CMAKE_GENERATOR=Ninja; fi
    if [ -z "${CMAKE_CXX_COMPILER_LAUNCHER:-}" ] && has_command ccache; then
      export CMAKE_CXX_COMPILER_LAUNCHER=ccache
    fi
  else
    unset CMAKE_GENERATOR
  fi
  step "Configuring $dir" "$dir/configure.log" cmake --preset "$preset" "${options[@]}" &&
    step "Building $dir on $jobs cores" "$dir/build.log" cmake --build --preset "$preset" -j "$jobs" "${targets[@]}"
}

test_preset() {
  local preset=$1 progress=()
  shift
  if [ -t 1 ]; then progress=(--progress); fi
  # Threads that wait must not keep the cores of other tests busy.
  OMP_WAIT_POLICY=${OMP_WAIT_POLICY:-passive} \
    ctest --preset "$preset" -j "$jobs" --no-tests=error "${progress[@]}" "$@"
}

# Leaks are looked for where the sanitizer can: not under a debugger, nor in every container.
leak_detection_works() {
  local dir
  dir=$(mktemp -d)
  echo 'int main() { return 0; }' >"$dir/probe.cpp"
  clang++ -fsanitize=address "$dir/probe.cpp" -o "$dir/probe" 2>/dev/null &&
    ASAN_OPTIONS=detect_leaks=1 "$dir/probe" >/dev/null 2>&1
  local works=$?
  rm -r "$dir"
  return $works
}
