"""Other engines: one adapter each, written as a competent user of that engine would.

Their joint is the chain input shaft (x), cross (y), output shaft (z), whose output axis a bearing
holds at the joint angle; what the engine does not do itself (closing the loop, solving for the
closure forces) the adapter does by hand and says so in its settings.
"""
