"""Teams: who has a take, who is asked for a second review, recipes, and retried decisions."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"


def upgrade() -> None:
    """Add a column to the journal, and three tables; no line of a journal changes."""
    op.add_column("journal", sa.Column("token", sa.String(32)))
    op.create_table(
        "claims",
        sa.Column("take", sa.String(64), sa.ForeignKey("takes.sha256"), primary_key=True),
        sa.Column("seat", sa.Text, primary_key=True),
        sa.Column("review", sa.Integer, sa.ForeignKey("reviews.id"), nullable=False, index=True),
        sa.Column("operator", sa.Text, nullable=False),
        sa.Column("session", sa.String(32), nullable=False),
        sa.Column("since", sa.DateTime, nullable=False),
        sa.Column("until", sa.DateTime, nullable=False),
    )
    op.create_table(
        "second_reviews",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("take", sa.String(64), sa.ForeignKey("takes.sha256"), nullable=False, index=True),
        sa.Column("asked_by", sa.Text, nullable=False),
        sa.Column("asked_of", sa.Text),
        sa.Column("blinded", sa.Boolean, nullable=False),
        sa.Column("note", sa.Text, nullable=False),
        sa.Column("at", sa.DateTime, nullable=False),
        sa.Column("ended", sa.DateTime),
        sa.Column("ended_by", sa.Text),
        sa.Column("review", sa.Integer, sa.ForeignKey("reviews.id")),
    )
    op.create_table(
        "recipes",
        sa.Column("name", sa.Text, primary_key=True),
        sa.Column("version", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("content", sa.JSON, nullable=False),
        sa.Column("author", sa.Text, nullable=False),
        sa.Column("at", sa.DateTime, nullable=False),
    )
