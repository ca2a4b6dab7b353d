"""One file per program that is measured side by side; each runs alone, in the environment of its program."""
