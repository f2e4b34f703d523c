"""The gap: `python -m benchmarks.gap` times a search (`measured_search`), `look_alikes` lets one go on until a maneuver has told,
`deciding_numbers` moves the numbers of the search by evidence, `cylinder_bench` makes somebody else's logs."""
