"""Where Alembic starts; the connection, with its transaction and its lock, is handed in."""

from alembic import context

from markermend.review.schema import VERSION_TABLE

context.configure(
    connection=context.config.attributes["connection"],
    version_table=VERSION_TABLE,
)
context.run_migrations()
