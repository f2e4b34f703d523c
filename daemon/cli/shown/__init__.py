"""How commands show things in a terminal: tables, progress, numbers in the rig file's units. Imports no command."""
