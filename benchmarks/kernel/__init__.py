"""The simulation kernel: `python -m benchmarks.kernel` by itself, `beside` C and scipy, `batches` on two threads, `windows` as the gap cuts
them."""
