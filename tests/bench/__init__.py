"""Speed and memory; run by `make bench`, apart from the tests."""
