"""One thread for matrix products, within and no longer, nested or not."""

from threadpoolctl import threadpool_info, threadpool_limits

from orbitscan.processing.kernels.blas import SingleThreaded


def threads():
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


@SingleThreaded()
def counted():
    return threads()


def test_products_have_one_thread_within_and_as_many_as_before_after():
    with threadpool_limits(2, user_api="blas"):
        before = threads()
        with SingleThreaded():
            assert counted() == threads() == {1}
        assert threads() == before
