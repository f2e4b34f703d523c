"""Commands that show live data, or a log as if it were live: the web page, the terminal, Foxglove."""
