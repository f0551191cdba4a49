"""Makes the runs of an experiment on several workers, by Dask.

    python -m pathspace.distribute exp.toml --workers 4
    python -m pathspace.distribute exp.toml -o results/exp --scheduler tcp://head:8786
    python -m pathspace.distribute exp.toml --scheduler-file /shared/scheduler.json

Without a scheduler, workers are processes on this machine. Else they are those of a Dask cluster
that runs already, on machines that see the manifest, the program and the experiment's folder under
the same paths. Every run is a job of its own: a worker that is lost loses the run it was at, which
another one makes, and nothing else. Images of a budget in samples have the bits of a local run.
Runs whose budget counts time never share a machine: there is one at a time on each, however many
workers it has. Afterwards `pathspace compare` makes the tables. Ctrl-C keeps what is finished; the
same command goes on.

exit codes: 0 done, 1 a run failed (the others are made), 2 wrong arguments, 3 two methods estimate
different images, 130 interrupted
"""

import argparse
import os
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path

from dask import config
from distributed import Client, LocalCluster, as_completed
from distributed.security import Security

from .distributed_job import Outcome, Task, make, sees
from .distributed_progress import Progress

ROOT = Path(__file__).resolve().parents[2]


class UsageError(Exception):
    """The command line makes no sense."""


def parser() -> argparse.ArgumentParser:
    """Make the parser."""
    parser = argparse.ArgumentParser(
        prog="scripts/distribute",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("manifest", type=Path, help="exp.toml, as `pathspace compare` takes it")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="DIR", help="default: the manifest without .toml"
    )
    parser.add_argument(
        "--workers", type=int, metavar="N", help="processes on this machine; default: its cores"
    )
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask cluster that runs")
    parser.add_argument("--scheduler-file", type=Path, metavar="FILE", help="that it has written")
    parser.add_argument(
        "--pathspace",
        type=Path,
        metavar="PROGRAM",
        default=ROOT / "target/release/pathspace",
        help="default: the one built here",
    )
    return parser


def is_timed(manifest: Path) -> bool:
    """Tell whether the budget of a manifest counts time."""
    try:
        return "spp" not in tomllib.loads(manifest.read_text(encoding="utf-8")).get("budget", {})
    except (OSError, ValueError) as error:
        raise UsageError(f"{manifest}: {error}") from None


def compare(options: argparse.Namespace) -> list[str]:
    """Give the command that all jobs share."""
    return [
        str(options.pathspace.resolve()),
        "compare",
        str(options.manifest.resolve()),
        "-o",
        str(options.output),
    ]


def jobs_of(command: Sequence[str]) -> list[str]:
    """List the runs that are missing."""
    listed = subprocess.run([*command, "--list-jobs"], capture_output=True, text=True, check=False)
    if listed.returncode != 0:
        lines = listed.stderr.strip().splitlines()
        raise UsageError(lines[-1] if lines else "the jobs cannot be listed")
    return listed.stdout.split("\n")[:-1]


def connect(options: argparse.Namespace, jobs: int, *, timed: bool) -> Client:
    """Find the cluster, or start one here."""
    if options.scheduler or options.scheduler_file:
        try:
            return Client(options.scheduler, scheduler_file=options.scheduler_file, timeout="20s")
        except (OSError, TimeoutError, ValueError) as error:
            where = options.scheduler or options.scheduler_file
            raise UsageError(f"{where}: no Dask scheduler there ({error})") from None
    wanted = options.workers or os.cpu_count() or 1
    if wanted < 1:
        raise UsageError(f"--workers {wanted}: expected 1 or more")
    count = 1 if timed else min(wanted, jobs)
    if timed and (options.workers or 1) > 1:
        say("one worker instead of several: runs whose budget counts time never share a machine")
    # Results are small and the machine is ours: no dashboard, no encryption.
    cluster = LocalCluster(
        n_workers=count,
        threads_per_worker=1,
        dashboard_address=None,
        security=Security(),
        local_directory=str(options.output / ".dask"),
    )
    return Client(cluster)


def check_folder(client: Client, folder: Path) -> None:
    """Refuse workers that do not see the experiment's folder."""
    token = folder / f".seen-{os.getpid()}"
    token.touch()
    try:
        client.wait_for_workers(1, timeout=60)
        for worker, seen in client.run(sees, str(token)).items():
            if not seen:
                raise UsageError(f"worker {worker} does not see {folder}; put it on a shared disk")
    except TimeoutError:
        raise UsageError("the cluster has no worker") from None
    finally:
        token.unlink()


def threads_of(client: Client, *, timed: bool) -> int:
    """Share the cores of a machine among its workers; runs that are timed have all of them."""
    if timed:
        return 0
    hosts = [worker["host"] for worker in client.scheduler_info(n_workers=-1)["workers"].values()]
    most = max((hosts.count(host) for host in hosts), default=1)
    return max(1, (os.cpu_count() or 1) // most)


def run_all(client: Client, tasks: Sequence[Task]) -> list[Outcome]:
    """Make all runs; tell how it goes on."""
    futures = [client.submit(make, task, key=f"run {task.job}", pure=False) for task in tasks]
    outcomes = []
    with Progress(len(tasks)) as progress:
        for future in as_completed(futures):
            if future.status == "finished":
                outcome = future.result()
            else:
                job = str(future.key).removeprefix("run ")
                outcome = Outcome(job, "", 0.0, f"its workers were lost ({future.exception()})")
            outcomes.append(outcome)
            progress.ended(outcome)
    return outcomes


def distribute(options: argparse.Namespace) -> int:
    """Do what the command line says; return the exit status."""
    timed = is_timed(options.manifest)
    if not options.pathspace.is_file():
        raise UsageError(f"{options.pathspace}: no such program; run cargo build --release")
    options.output = (options.output or options.manifest.with_suffix("")).resolve()
    command = compare(options)
    failed: list[Outcome] = []
    if jobs := jobs_of(command):
        # A run that has brought down three workers would bring down the next, too.
        with (
            config.set({"distributed.scheduler.allowed-failures": 3}),
            connect(options, len(jobs), timed=timed) as client,
        ):
            check_folder(client, options.output)
            threads = threads_of(client, timed=timed)
            folder = str(options.output)
            tasks = [Task(job, tuple(command), folder, threads, timed) for job in jobs]
            outcomes = run_all(client, tasks)
            if client.cluster is not None:
                client.cluster.close()
        failed = [outcome for outcome in outcomes if outcome.error]
    for outcome in failed:
        say(f"{outcome.job}: {outcome.error}")
    if failed:
        say(f"{len(failed)} of {len(jobs)} runs failed; the same command tries them again")
        return 1
    return subprocess.run(command, check=False).returncode


def say(text: str) -> None:
    """Tell the user something."""
    print(f"distribute: {text}", file=sys.stderr)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    options = parser().parse_args(arguments)
    try:
        return distribute(options)
    except UsageError as error:
        say(str(error))
        return 2
    except KeyboardInterrupt:
        say("interrupted: finished runs are kept, and the same command goes on")
        return 130


if __name__ == "__main__":
    sys.exit(main())
