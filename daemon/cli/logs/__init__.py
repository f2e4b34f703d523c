"""Commands that look at logs: info, check, plot, diff, export, import, recover, replay, runs."""
