"""Archives: what a batch found in each take, and how each take of a folder ended."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    """Create the three tables; nothing that was there changes."""
    op.create_table(
        "scans",
        sa.Column("take", sa.String(64), primary_key=True),
        sa.Column("settings", sa.String(64), primary_key=True),
        sa.Column("at", sa.DateTime, nullable=False),
        sa.Column("summary", sa.JSON, nullable=False),
        sa.Column("findings", sa.JSON, nullable=False),
        sa.Column("repaired", sa.JSON),
    )
    op.create_table(
        "archives",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("folder", sa.Text, nullable=False),
        sa.Column("settings", sa.String(64), nullable=False),
        sa.Column("content", sa.JSON, nullable=False),
        sa.Column("begun", sa.DateTime, nullable=False),
        sa.UniqueConstraint("folder", "settings", name="one_archive_per_settings"),
    )
    op.create_table(
        "archive_takes",
        sa.Column("archive", sa.Integer, sa.ForeignKey("archives.id"), primary_key=True),
        sa.Column("name", sa.Text, primary_key=True),
        sa.Column("take", sa.String(64)),
        sa.Column("status", sa.String(16), nullable=False),
        sa.Column("reason", sa.Text, nullable=False),
    )
