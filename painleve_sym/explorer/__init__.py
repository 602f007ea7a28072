"""The explorer: one HTML page in which a mechanism's contact mechanics is computed live."""
