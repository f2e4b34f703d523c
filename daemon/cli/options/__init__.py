"""Values of options as several commands take them."""
