"""Who replays many bags: processes of this machine, or a cluster; one that dies loses no bag."""

import multiprocessing
import os
import signal
import threading
from collections import Counter, deque
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool

from peg_on_hole_ros.cli.many_bags.task import Task, failed, work
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.startup.exit_codes import INTERNAL, described

# How often a bag is begun anew whose worker dies, and for how long a cluster is waited for [s].
RETRIES = 2
_PATIENCE = 10


def on_this_machine(tasks: Iterable[Task], jobs: int) -> Iterator[dict]:
    """
    Yield the results of tasks as they come, from so many processes.

    Where a process dies, as by the kernel when memory is short, what was under way is done anew,
    one bag at a time: so it shows which bag it is that kills its worker, and only that is given
    up, after `RETRIES` more attempts.
    """
    waiting, alone, deaths = deque(tasks), deque(), Counter()
    while waiting or alone:
        queue, workers = (waiting, jobs) if waiting else (alone, 1)
        lost = yield from _until_one_dies(queue, workers)
        for task in lost:
            if workers == 1:
                deaths[task.name] += 1
            if deaths[task.name] > RETRIES:
                yield _killed(task, f"its worker was killed {deaths[task.name]} times")
            else:
                alone.append(task)


def _until_one_dies(queue, workers):
    """Yield results; return the tasks that were under way when a process died."""
    running, proved = {}, False
    # Of a process with threads and compiled code no copy is made.
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, context, _begin)
    try:
        while queue or running:
            try:
                while queue and len(running) < workers:
                    future = pool.submit(work, queue[0])
                    running[future] = queue.popleft()
            except BrokenProcessPool:
                # One that died while it had nothing to do.
                if not running and proved:
                    return []
                if not running:
                    raise PegOnHoleError(
                        "no process for the work can be started: is there memory, are processes "
                        "limited (ulimit -u)?"
                    ) from None
            finished, _ = wait(running, return_when=FIRST_COMPLETED)
            broken = [f for f in finished if isinstance(f.exception(), BrokenProcessPool)]
            if broken:
                # The others of them are broken too, or were ready just before.
                finished, _ = wait(running)
            lost = []
            for future in finished:
                task, error = running.pop(future), future.exception()
                if isinstance(error, BrokenProcessPool):
                    lost.append(task)
                else:
                    proved = True
                    yield _killed(task, described(error)) if error else future.result()
            if broken:
                return lost
        pool.shutdown()
        return []
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for process in multiprocessing.active_children():
            process.terminate()


def _begin():
    """Make a process end with its parent, however that ends; Ctrl-C is the parent's to see."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def follow():
        parent.join()
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


def on_cluster(tasks: Iterable[Task], address: str) -> Iterator[dict]:
    """
    Yield the results of tasks as they come from the workers of a dask cluster.

    Bags and results lie where all of them find them by the same path.

    Raises
    ------
    PegOnHoleError
        dask.distributed is not installed, or there is no scheduler.

    """
    try:
        from distributed import Client, as_completed
    except ModuleNotFoundError as error:
        raise PegOnHoleError(f"--dask needs {error.name}: pip install distributed") from None
    try:
        client = Client(address, timeout=_PATIENCE)
    except (OSError, ValueError, TypeError) as error:
        raise PegOnHoleError(f"no dask scheduler answers at {address}: {error}") from None
    try:
        futures = {}
        for task in tasks:
            futures[client.submit(work, task, retries=RETRIES, pure=False)] = task
        for future in as_completed(futures):
            error = future.exception()
            yield _killed(futures[future], described(error)) if error else future.result()
    finally:
        client.close()


def _killed(task, why):
    return failed(task, INTERNAL, f"{why}: out of memory, or a fault of the program")
