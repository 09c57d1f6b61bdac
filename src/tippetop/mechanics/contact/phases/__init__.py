"""A body whose contact with the plane may change: it slips, rolls, flies, lands, on one ball of it or another."""
