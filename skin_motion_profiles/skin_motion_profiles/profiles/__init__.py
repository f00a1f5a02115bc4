"""One file per profile; the catalogue finds them here."""
