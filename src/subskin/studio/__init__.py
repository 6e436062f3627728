"""A page on this machine: the finger, its memo, a live sensor and a search, to look at and to move by hand.

`subskin studio` opens it. It needs `pip install "subskin[studio]"`: starlette, uvicorn and websockets. The page is
written by hand, asks nothing of other machines, and is answered to no one else (`guard`).
"""
