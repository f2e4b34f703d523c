"""What the study found, counted: scores with their intervals, tables, pictures and the page."""
