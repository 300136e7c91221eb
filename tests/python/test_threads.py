"""Threads, the interpreter's lock, progress and cancelling, and processes made by fork."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import recon
from clouds import inner, jittered

LARGE = jittered(60, 3)  # 216,000 particles: a fit of a second or so


def test_one_object_is_used_by_many_threads() -> None:
    x, t = jittered(30, 2), inner(2000, 2)
    sources = recon.Sources(x)
    fit = recon.reconstruct(sources, t, degree=2)
    expected = [fit @ x, fit.T @ t, fit.gradient() @ x, recon.reconstruct(sources, t) @ x]

    def work(_: int) -> bool:
        got = [fit @ x, fit.T @ t, fit.gradient() @ x, recon.reconstruct(sources, t) @ x]
        return all(np.array_equal(a, b) for a, b in zip(got, expected))

    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(work, range(64)))


def test_other_threads_go_on_while_one_computes() -> None:
    count = 0
    done = threading.Event()

    def tick() -> None:
        nonlocal count
        while not done.is_set():
            count += 1
            time.sleep(0.001)

    ticking = threading.Thread(target=tick)
    ticking.start()
    before = count
    begin = time.monotonic()
    recon.reconstruct(LARGE, LARGE[::2], degree=2, threads=1)
    elapsed, ticks = time.monotonic() - begin, count - before
    done.set()
    ticking.join()
    assert ticks > 10 * elapsed  # under the lock there would be next to none


def test_an_update_beside_a_use_is_an_error_and_no_crash() -> None:
    sources = recon.Sources(LARGE)
    fit = recon.reconstruct(sources, LARGE[:10])
    seen: list[str] = []

    def progress(_: float) -> None:
        try:
            sources.update(LARGE[:10])
        except RuntimeError as error:
            seen.append(str(error))
        assert (fit @ LARGE).shape == (10, 3)  # another use is no trouble

    recon.reconstruct(sources, LARGE, degree=3, threads=1, progress=progress)
    assert "the object Sources cannot be updated while another call uses it" in seen
    sources.update(LARGE[:1000])
    fit.update(LARGE[:10])
    assert fit.shape == (10, 1000)

    # Threads that update and use one object: results or errors, nothing else.
    clouds = [jittered(20, 2, seed) for seed in range(3)]
    small = recon.Sources(clouds[0])
    shared = recon.reconstruct(small, inner(200, 2))

    def work(i: int) -> bool:
        try:
            if i % 4 == 0:
                small.update(clouds[i % 3])
            elif i % 4 == 1:
                shared.update(inner(100 + i, 2))
            elif i % 4 == 2:
                return bool(np.isfinite(shared @ clouds[0]).all())
            else:
                return bool(np.isfinite((shared.gradient().T @ np.ones((shared.shape[0], 2)))).all())
        except (RuntimeError, recon.InvalidArgument):
            pass
        return True

    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(work, range(400)))


def test_progress_is_told_and_cancels() -> None:
    told: list[float] = []
    recon.reconstruct(LARGE, LARGE, degree=3, solver="gram_schmidt", threads=1, progress=told.append)
    assert told and told == sorted(told) and 0 <= told[0] and told[-1] <= 1

    with pytest.raises(recon.Cancelled, match="cancelled by the caller's progress function"):
        recon.reconstruct(LARGE, LARGE, degree=3, threads=1, progress=lambda fraction: False)

    def fail(fraction: float) -> None:
        raise LookupError("from the progress function")

    with pytest.raises(LookupError, match="from the progress function"):
        recon.reconstruct(LARGE, LARGE, degree=3, threads=1, progress=fail)


def run(code: str, timeout: float = 120) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=os.path.dirname(__file__),
    )


def test_the_keyboard_interrupts_a_long_call() -> None:
    process = run(
        "import recon, signal, numpy as np\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # shells ignore it in the background
        "x = np.random.default_rng(1).uniform(size=(400000, 3))\n"
        "print('ready', flush=True)\n"
        "try:\n"
        "    for i in range(20): recon.reconstruct(x, x, degree=3, solver='gram_schmidt')\n"
        "except KeyboardInterrupt:\n"
        "    print('interrupted')\n"
    )
    assert process.stdout is not None and process.stdout.readline() == "ready\n"
    time.sleep(1)
    process.send_signal(signal.SIGINT)
    out, error = process.communicate(timeout=120)
    assert out == "interrupted\n", error


def test_a_child_of_fork_computes() -> None:
    x, t = jittered(40, 2), inner(3000, 2)
    fit = recon.reconstruct(x, t)  # the parent has had threads
    expected = fit @ x
    child = os.fork()
    if child == 0:
        try:
            fine = np.array_equal(recon.reconstruct(x, t) @ x, expected)
            fine = fine and np.array_equal(fit @ x, expected) and recon.default_threads() == 1
            fine = fine and np.array_equal(recon.reconstruct(x, t, threads=4) @ x, expected)
            os._exit(0 if fine else 3)
        finally:
            os._exit(4)
    for _ in range(600):
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            break
        time.sleep(0.1)
    else:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        pytest.fail("the child hangs")
    assert os.waitstatus_to_exitcode(status) == 0


def fit_in_process(seed: int) -> Any:
    x = jittered(30, 2, seed)
    return recon.reconstruct(x, inner(500, 2)) @ x


@pytest.mark.parametrize("start", ["fork", "spawn"])
def test_pools_of_processes(start: str) -> None:
    recon.reconstruct(LARGE[:20000], LARGE[:2000])
    with multiprocessing.get_context(start).Pool(2) as pool:
        made = pool.map_async(fit_in_process, range(4)).get(timeout=100)
    for seed, result in enumerate(made):
        np.testing.assert_array_equal(result, fit_in_process(seed))
