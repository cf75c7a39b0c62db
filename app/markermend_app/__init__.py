"""The MarkerMend application: a command line and a page; it shows and sends, `markermend` computes."""
