"""Write and read stores: zarr v3 folders that survive a kill and a power failure. No physics.

- `ledger.Ledger` is the lock of a store and the list of its acknowledged chunks.
- `table.Table` gathers rows of a table until they fill a chunk.
- `writer.Writer` is the thread on which a store is written.

Rows go to `Table.append`, full chunks to `Ledger.put`, the remaining rows to the tail of
`Ledger.commit`; all files are written by `folder.Folder`. Reading compares a store with its ledger
first (`root.attributes`), then `root.open_group` returns a group as an xarray Dataset.
"""
