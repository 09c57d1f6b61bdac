"""What the engine costs against the best of the field: cases, peers, measurements, report."""
