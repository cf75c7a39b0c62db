"""What the page shows and what it may be asked: view-models, no drawing."""
