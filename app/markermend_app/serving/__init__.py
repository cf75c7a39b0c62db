"""The server around the page: who may come in, from where, and what leaves it."""
