"""Spreads `biped robustness` over a Dask cluster; the result is the file that one machine would have written.

    pip install distributed
    python launch/robustness/dask_sweep.py --shards 8 --out out/robustness -- --seeds 10

Without --scheduler two workers on this machine do the work. Options after -- go to every `biped robustness` unchanged.
The workers need the program under the same path and nothing else: tables come back through Dask.
"""

import argparse
import os
import pathlib
import subprocess
import tempfile

from dask.distributed import Client, LocalCluster, as_completed


def shard(program, options, i, n):
    """The table of the i-th of n shards, as text. One thread: Dask knows how many tasks a worker may run at once."""
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "robustness", *options, "--shard", f"{i}/{n}", "--quiet", "--out", folder]
        alone = {**os.environ, "RAYON_NUM_THREADS": "1"}
        subprocess.run(command, check=True, env=alone, stdout=subprocess.DEVNULL)
        return i, (pathlib.Path(folder) / f"robustness-{i}-of-{n}.csv").read_text()


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--scheduler", help="address of a running Dask scheduler, as tcp://host:8786")
    arguments.add_argument("--shards", type=int, default=8, help="a few per worker, so that all workers end at about the same time")
    arguments.add_argument("--program", default="target/release/biped")
    arguments.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/robustness"))
    arguments.add_argument("options", nargs="*", help="options of biped robustness, after --")
    args = arguments.parse_args()
    program = str(pathlib.Path(args.program).resolve())
    here = None if args.scheduler else LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with Client(args.scheduler or here) as cluster, tempfile.TemporaryDirectory() as folder:
        numbers = range(1, args.shards + 1)
        tasks = [cluster.submit(shard, program, args.options, i, args.shards, pure=False) for i in numbers]
        files = []
        for task, (i, table) in as_completed(tasks, with_results=True):
            files.append(pathlib.Path(folder) / f"{i}.csv")
            files[-1].write_text(table)
            print(f"shard {i}, {len(files)} of {args.shards}", flush=True)
        merge = [program, "robustness", *args.options, "--out", args.out, "--merge", *files]
        subprocess.run(merge, check=True)
    if here:
        here.close()


if __name__ == "__main__":
    main()
