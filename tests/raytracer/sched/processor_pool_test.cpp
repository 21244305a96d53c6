#include "raytracer/sched/processor_pool.hpp"

#include "raytracer/sched/green_processor.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/farm_bench.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

ProcessorPool::Member threads_of(Job& job, int threads) { return {"here", "threads", threads, true, false, std::make_shared<ThreadProcessor>(job.view, job.blocks, threads), {}}; }
ProcessorPool::Member green_of(Job& job) { return {"here", "green", 1, true, true, std::make_shared<GreenProcessor>(job.view, job.blocks), {}}; }

}  // namespace

TEST_CASE("any mix of green and thread processors makes the same picture", "[raytracer][sched]") {
    Job alone(farm_scene());
    const std::string wanted = bytes_of(render(alone, 1));
    for (const int green : {0, 1, 2})
        for (const int thread_members : {0, 1, 3}) {
            if (green + thread_members == 0) continue;
            INFO(green << " green, " << thread_members << " of threads");
            Job job(farm_scene());
            ProcessorPool pool(pool_settings(job));
            for (int i = 0; i < green; ++i) pool.add(green_of(job));
            for (int i = 0; i < thread_members; ++i) pool.add(threads_of(job, 1 + i));
            Film film = empty_film(job);
            CHECK(render_film({job.view, pool, true, nullptr}, film).tiles == 28);
            CHECK(bytes_of(film) == wanted);
        }
}

TEST_CASE("a pool takes coarse passes, too, and samples that come later", "[raytracer][sched]") {
    Scene scene = small_scene();
    scene.quality.coarse_step = 8;
    Job alone(scene), job(scene);
    const std::string wanted = bytes_of(render(alone, 1));
    ProcessorPool pool(pool_settings(job));
    pool.add(threads_of(job, 2));
    Film film = empty_film(job);
    (void)render_film({job.view, pool, true, nullptr}, film);
    CHECK(bytes_of(film) == wanted);
}

TEST_CASE("members may be added and removed in the middle", "[raytracer][sched]") {
    Job alone(farm_scene()), job(farm_scene());
    const std::string wanted = bytes_of(render(alone, 1));
    ProcessorPool pool(pool_settings(job));
    auto first = pool.add(threads_of(job, 1));
    const auto tiles = plan_tiles(97, 53, 1, 16, "rows").front();
    for (const RenderTile& t : tiles) pool.submit(t);
    Film film = empty_film(job);
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        const auto result = pool.take();
        REQUIRE(result);
        film.add(*result);
        if (i % 5 == 2) {
            const auto next = pool.add(threads_of(job, 1));
            pool.remove(first, "test");
            first = next;
        }
    }
    CHECK(bytes_of(film) == wanted);
    CHECK(pool.status().size() == 1);
    CHECK(pool.counts().lost == 6);
}

TEST_CASE("what a trusted member throws reaches the taker with its type, and a cancelled pool ends", "[raytracer][sched]") {
    struct Odd : std::runtime_error {
        using std::runtime_error::runtime_error;
    };
    class Throwing final : public TileProcessor {
    public:
        int capacity() const noexcept override { return 1; }
        void submit(RenderTile) override {}
        bool wait(std::chrono::milliseconds) override { return true; }
        std::optional<TileResult> take() override { throw Odd("odd"); }
        void close() noexcept override {}
        void cancel() noexcept override {}
    };
    Job job(farm_scene());
    {
        ProcessorPool pool(pool_settings(job));
        pool.add({"odd", "threads", 1, true, false, std::make_shared<Throwing>(), {}});
        pool.submit(plan_tiles(97, 53, 1, 16, "rows").front().front());
        CHECK_THROWS_AS(pool.take(), Odd);
    }
    ProcessorPool pool(pool_settings(job));
    pool.submit(plan_tiles(97, 53, 1, 16, "rows").front().front());
    pool.cancel();
    CHECK_FALSE(pool.take());
}

TEST_CASE("a closed pool is drained, then it is empty", "[raytracer][sched]") {
    Job job(farm_scene());
    ProcessorPool pool(pool_settings(job));
    pool.add(threads_of(job, 1));
    const auto tiles = plan_tiles(97, 53, 1, 16, "rows").front();
    for (const RenderTile& t : tiles) pool.submit(t);
    pool.close();
    pool.submit(tiles.front());  // too late
    std::size_t n = 0;
    while (pool.take()) ++n;
    CHECK(n == tiles.size());
}
