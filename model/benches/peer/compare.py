"""Ours and PyTorch's in turn, several times; medians and their ratio, processor seconds, one JSON line per thread count.
With --bf16 both sides multiply bf16 numbers, ours in the tiles of a processor that has them (AMX).

    python compare.py BENCH_BINARY [--preset paper] [--queries 10240] [--pairs 3] [--threads 1 2] [--bf16]
"""
import argparse
import json
import os
import statistics
import subprocess
import sys


def last_line(command, threads):
    environment = dict(os.environ, RAYON_NUM_THREADS=str(threads), OMP_NUM_THREADS=str(threads))
    done = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
    return json.loads(done.stdout.strip().splitlines()[-1])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("binary")
    parser.add_argument("--preset", default="paper")
    parser.add_argument("--queries", type=int, default=10240)
    parser.add_argument("--pairs", type=int, default=3)
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--bf16", action="store_true")
    args = parser.parse_args()
    peer = os.path.join(os.path.dirname(os.path.abspath(__file__)), "network.py")
    for threads in args.threads:
        ours, theirs = [], []
        for _ in range(args.pairs):
            ours.append(last_line([args.binary, args.preset, "infer", str(args.queries), "cpu", "1"]
                                  + ["half"] * args.bf16, threads))
            command = [sys.executable, peer, args.preset, "--queries", str(args.queries), "--repeats", "1"]
            command += ["--threads", str(threads)] + ["--bf16"] * args.bf16
            theirs.append(last_line(command, threads))
            print(json.dumps(dict(ours=ours[-1], peer=theirs[-1])), file=sys.stderr, flush=True)
        a, b = (statistics.median(run["cpu_s"] for run in runs) for runs in (ours, theirs))
        peaks = (max(run["peak_mib"] for run in runs) for runs in (ours, theirs))
        print(json.dumps(dict(threads=threads, queries=args.queries, dtype=theirs[-1]["dtype"], ours_cpu_s=a,
                              peer_cpu_s=b, ratio=round(a / b, 3), peak_mib=list(peaks))), flush=True)


main()
