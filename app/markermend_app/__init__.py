"""The MarkerMend application: it shows and sends, and `markermend` computes."""
