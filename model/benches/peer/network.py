"""The articulation network in PyTorch, to measure ours against; random weights, one JSON line a run.

Shapes: B batch, N points, L shape tokens, P parts, Q queries, D width.
"""
import argparse
import json
import resource
import time

import torch
from torch import nn
from torch.nn import functional as F

PRESETS = {
    "paper": dict(width=768, heads=12, blocks=6, points=10240, tokens=2048, chunk=4096, features=448, text=768),
    "small": dict(width=256, heads=4, blocks=4, points=4096, tokens=512, chunk=2048, features=56, text=256),
}
PARTS = 16


class Attention(nn.Module):
    """Keys and values are made once by `context`; q and k are RMS-normalised head by head."""

    def __init__(self, width, heads):
        super().__init__()
        self.heads = heads
        self.q, self.k, self.v = (nn.Linear(width, width, bias=False) for _ in range(3))
        self.norm_q, self.norm_k = (nn.RMSNorm(width // heads, eps=1e-6) for _ in range(2))
        self.out = nn.Linear(width, width)

    def split(self, x):
        return x.unflatten(-1, (self.heads, -1)).transpose(1, 2)

    def context(self, x):
        return self.norm_k(self.split(self.k(x))), self.split(self.v(x))

    def forward(self, x, context):
        q = self.norm_q(self.split(self.q(x)))
        return self.out(F.scaled_dot_product_attention(q, *context).transpose(1, 2).flatten(2))


class Look(nn.Module):
    def __init__(self, width, heads):
        super().__init__()
        self.norm, self.attention = nn.LayerNorm(width), Attention(width, heads)

    def context(self, x):
        return self.attention.context(x)

    def forward(self, x, context=None):
        y = self.norm(x)
        return x + self.attention(y, self.context(y) if context is None else context)


class Think(nn.Module):
    def __init__(self, width):
        super().__init__()
        self.norm, self.inner, self.outer = nn.LayerNorm(width), nn.Linear(width, 8 * width), nn.Linear(4 * width, width)

    def forward(self, x):
        value, gate = self.inner(self.norm(x)).chunk(2, -1)
        return x + self.outer(value * F.gelu(gate))


class Stream(nn.Module):
    def __init__(self, width, heads):
        super().__init__()
        self.shape, self.parts, self.think = Look(width, heads), Look(width, heads), Think(width)


def mlp(*widths):
    return nn.Sequential(nn.Linear(widths[0], widths[1]), nn.SiLU(), nn.Linear(widths[1], widths[2]))


class Network(nn.Module):
    def __init__(self, width, heads, blocks, tokens, features, text, **_):
        super().__init__()
        self.position, self.normal = mlp(195, width, width), mlp(195, width, width)
        self.feature, self.text = nn.Linear(features, width), mlp(text, width, width)
        self.latents = nn.Parameter(0.02 * torch.randn(tokens, width))
        self.gather, self.digest = Look(width, heads), Think(width)
        self.part = nn.ModuleList(Stream(width, heads) for _ in range(blocks))
        self.query = nn.ModuleList(Stream(width, heads) for _ in range(blocks))
        self.head_q, self.head_l = nn.Linear(width, 4 * width), nn.Linear(width, 4 * width, bias=False)
        self.score = nn.Linear(4 * width, 1)

    def code(self, x):
        waves = 1000 * x.unsqueeze(-1) * torch.exp(torch.arange(32) * (-9.210340371976184 / 32))
        return torch.cat([torch.cat([waves.sin(), waves.cos()], -1).flatten(-2), x], -1).to(self.latents.dtype)

    def embed(self, xyz, normals, features):
        return self.position(self.code(xyz)) + self.normal(self.code(normals)) + self.feature(features)

    def remember(self, shape, parts, texts):
        points = self.embed(*shape)
        z = self.digest(self.gather(self.latents.unsqueeze(0), self.gather.context(points)))
        parts = self.text(texts) + self.embed(*parts)
        scenes = []
        for part, query in zip(self.part, self.query):
            parts = part.think(part.parts(part.shape(parts, part.shape.context(z))))
            scenes.append((query.shape.context(z), query.parts.context(parts)))
        return scenes, self.head_l(parts)

    def decode(self, memory, queries):
        scenes, parts = memory
        q = self.embed(*queries)
        for query, (shape, part) in zip(self.query, scenes):
            q = query.think(query.parts(query.shape(q, shape), part))
        q, rows = self.head_q(q), []
        for piece in q.split(512, 1):
            rows.append(self.score(F.silu(piece.unsqueeze(2) + parts.unsqueeze(1))).squeeze(-1))
        return torch.cat(rows, 1)


def points(count, features, dtype):
    xyz = torch.rand(1, count, 3) - 0.5
    return xyz, F.normalize(torch.randn(1, count, 3), dim=-1), torch.randn(1, count, features, dtype=dtype)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("preset", choices=PRESETS)
    parser.add_argument("--queries", type=int, default=10240)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--bf16", action="store_true")
    parser.add_argument("--repeats", type=int, default=3)
    args = parser.parse_args()
    size, dtype = PRESETS[args.preset], torch.bfloat16 if args.bf16 else torch.float32
    torch.set_num_threads(args.threads)
    torch.manual_seed(1)
    network = Network(**size).eval().to(dtype)
    shape, parts = points(size["points"], size["features"], dtype), points(PARTS, size["features"], dtype)
    texts, queries = torch.randn(1, PARTS, size["text"], dtype=dtype), points(args.queries, size["features"], dtype)
    for _ in range(args.repeats):
        wall, before = time.perf_counter(), time.process_time()
        with torch.inference_mode():
            memory = network.remember(shape, parts, texts)
            for start in range(0, args.queries, size["chunk"]):
                network.decode(memory, [x[:, start:start + size["chunk"]] for x in queries]).argmax(-1)
        print(json.dumps(dict(
            what="infer", queries=args.queries, dtype=str(dtype), threads=args.threads,
            cpu_s=round(time.process_time() - before, 2), wall_s=round(time.perf_counter() - wall, 2),
            peak_mib=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
        )), flush=True)


main()
