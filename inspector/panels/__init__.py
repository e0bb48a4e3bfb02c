"""The panels for reviewing: tables, filters, and the card of the selected interval."""
