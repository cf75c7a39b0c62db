"""The first schema: takes, reviews, and their journals."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Create all tables."""
    op.create_table(
        "takes",
        sa.Column("sha256", sa.String(64), primary_key=True),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("path", sa.Text, index=True),
        sa.Column("n_frames", sa.Integer, nullable=False),
        sa.Column("rate", sa.Float, nullable=False),
        sa.Column("given_units", sa.String(8)),
        sa.Column("given_rate", sa.Float),
        sa.Column("first_seen", sa.DateTime, nullable=False),
        sa.Column("last_seen", sa.DateTime, nullable=False),
    )
    op.create_table(
        "reviews",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("take", sa.String(64), sa.ForeignKey("takes.sha256"), nullable=False),
        sa.Column("operator", sa.Text, nullable=False),
        sa.Column("purpose", sa.Text, nullable=False),
        sa.Column("status", sa.String(16), nullable=False),
        sa.Column("created", sa.DateTime, nullable=False),
        sa.UniqueConstraint("take", "operator", "purpose", name="one_review_per_purpose"),
    )
    op.create_table(
        "journal",
        sa.Column("review", sa.Integer, sa.ForeignKey("reviews.id"), primary_key=True),
        sa.Column("seq", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("action", sa.String(8), nullable=False),
        sa.Column("command", sa.JSON),
        sa.Column("operator", sa.Text, nullable=False),
        sa.Column("at", sa.DateTime, nullable=False),
    )
