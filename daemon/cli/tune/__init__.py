"""Commands that tune a rig: identify, design, shape, oil-table, warm-up, paper."""
