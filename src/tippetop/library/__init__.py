"""Public objects and calls of `import tippetop`: bodies, laws, runs."""
