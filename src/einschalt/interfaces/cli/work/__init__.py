"""What commands do: imported when they run, so that help does not wait for it."""
