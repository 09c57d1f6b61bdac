"""What `import tippetop` offers: bodies, laws and runs as objects, and the calls that take them."""
