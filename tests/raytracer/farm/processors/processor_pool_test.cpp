#include "raytracer/farm/processors/processor_pool.hpp"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <semaphore>

#include "raytracer/farm/processors/green_processor.hpp"
#include "tests/catch.hpp"
#include "tests/eventually.hpp"
#include "tests/raytracer/farm_bench.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

processors::ProcessorPool::Member make_threads(Job& job, int threads) {
    return {"here",  "threads",
            threads, true,
            false,   std::make_shared<processors::ThreadProcessor>(job.view, job.blocks, threads),
            {}};
}
/// Cannot trace anything: takes whatever it is given, and fails at the first of it.
class Failing final : public processors::TileProcessor {
public:
    int capacity() const noexcept override { return 1; }  // so that all get the same first
    void submit(tiles::RenderTile tile) override {
        const std::lock_guard lock(m_mutex);
        if (!m_tile)
            m_tile = tile;
        m_changed.notify_all();
    }
    bool wait(std::chrono::milliseconds) override { return true; }
    std::optional<tiles::TileResult> take() override {
        std::unique_lock lock(m_mutex);
        m_changed.wait(lock, [&] { return m_tile || m_over; });
        if (m_over)
            return std::nullopt;
        throw processors::FailingProcessor("it cannot render: out of memory", *m_tile);
    }
    void close() noexcept override {}
    void cancel() noexcept override {
        const std::lock_guard lock(m_mutex);
        m_over = true;
        m_changed.notify_all();
    }

private:
    std::mutex m_mutex;
    std::condition_variable m_changed;
    std::optional<tiles::RenderTile> m_tile;
    bool m_over = false;
};

/// Takes one tile at a time, and returns no result until it may continue.
class Slow final : public processors::TileProcessor {
public:
    explicit Slow(Job& job) : m_processor(job.view, job.blocks, 1) {}
    void resume() { m_may.release(); }
    int capacity() const noexcept override { return 1; }
    void submit(tiles::RenderTile tile) override { m_processor.submit(tile); }
    bool wait(std::chrono::milliseconds) override { return true; }
    std::optional<tiles::TileResult> take() override {
        m_may.acquire();
        m_may.release();
        return m_processor.take();
    }
    void close() noexcept override { m_processor.close(); }
    void cancel() noexcept override {
        m_processor.cancel();
        m_may.release();
    }

private:
    processors::ThreadProcessor m_processor;
    std::counting_semaphore<> m_may{0};
};

processors::ProcessorPool::Member failing(const std::string& identity) {
    processors::ProcessorPool::Member out{
        "failing", "socket", 1, false, false, std::make_shared<Failing>(), {}};
    out.identity = identity;
    return out;
}

/// Settings of a pool where `left` counts the members that have left.
processors::PoolSettings counting(Job& job, std::atomic<int>& left) {
    processors::PoolSettings out = pool_settings(job);
    out.gone = [&left](processors::ProcessorPool::MemberId, const std::string&, bool) { ++left; };
    return out;
}

/// A member that takes nothing: while it is present, the others are not the last.
void add_resting(processors::ProcessorPool& pool) {
    processors::ProcessorPool::Member resting = failing("host of one that rests");
    resting.paused = true;
    pool.add(std::move(resting));
}

void submit_all(processors::ProcessorPool& pool) {
    const auto tiles = tiles::plan_tiles(97, 53, 1, 16, core::TileOrder::kRows).front();
    for (const tiles::RenderTile& t : tiles)
        pool.submit(t);
}

/// Adds members that fail, each once the previous one is removed.
void add_in_turn(processors::ProcessorPool& pool, const std::vector<std::string>& identities,
                 const std::atomic<int>& left) {
    for (const std::string& name : identities) {
        const int before = left;
        pool.add(failing(name));
        REQUIRE(eventually([&] { return left > before; }));
    }
}

processors::ProcessorPool::Member make_green(Job& job) {
    return {"here", "green", 1,
            true,   true,    std::make_shared<processors::GreenProcessor>(job.view, job.blocks),
            {}};
}

/// The picture of all tiles that were submitted.
std::string render_all_tiles(processors::ProcessorPool& pool, const Job& job) {
    output::Film film = empty_film(job);
    for (int i = 0; i < 28; ++i) {
        const auto result = pool.take();
        REQUIRE(result);
        film.add(*result);
    }
    return to_bytes(film);
}

}  // namespace

TEST_CASE("any mix of green and thread processors makes the same picture", "[raytracer][sched]") {
    Job alone(farm_scene());
    const std::string wanted = to_bytes(render_scene(alone, 1));
    for (const int green : {0, 1, 2})
        for (const int thread_members : {0, 3}) {
            if (green + thread_members == 0)
                continue;
            INFO(green << " green, " << thread_members << " of threads");
            Job job(farm_scene());
            processors::ProcessorPool pool(pool_settings(job));
            for (int i = 0; i < green; ++i)
                pool.add(make_green(job));
            for (int i = 0; i < thread_members; ++i)
                pool.add(make_threads(job, 1 + i));
            output::Film film = empty_film(job);
            CHECK(render::render_film({job.view, pool, true, {}}, film).tiles == 28);
            CHECK(to_bytes(film) == wanted);
        }
}

TEST_CASE("a pool takes coarse passes, too, and later samples", "[raytracer][sched]") {
    scene::Scene scene = small_scene();
    scene.quality.coarse_step = 8;
    Job alone(scene), job(scene);
    const std::string wanted = to_bytes(render_scene(alone, 1));
    processors::ProcessorPool pool(pool_settings(job));
    pool.add(make_threads(job, 2));
    output::Film film = empty_film(job);
    (void)render::render_film({job.view, pool, true, {}}, film);
    CHECK(to_bytes(film) == wanted);
}

TEST_CASE("members may be added and removed in the middle", "[raytracer][sched]") {
    Job alone(farm_scene()), job(farm_scene());
    const std::string wanted = to_bytes(render_scene(alone, 1));
    processors::ProcessorPool pool(pool_settings(job));
    auto first = pool.add(make_threads(job, 1));
    const auto tiles = tiles::plan_tiles(97, 53, 1, 16, core::TileOrder::kRows).front();
    for (const tiles::RenderTile& t : tiles)
        pool.submit(t);
    output::Film film = empty_film(job);
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        const auto result = pool.take();
        REQUIRE(result);
        film.add(*result);
        if (i % 5 == 2) {
            const auto next = pool.add(make_threads(job, 1));
            pool.remove(first, "test");
            first = next;
        }
    }
    CHECK(to_bytes(film) == wanted);
    CHECK(pool.status().size() == 1);
    CHECK(pool.counts().lost == 6);
}

TEST_CASE("what a trusted member throws reaches the taker with its type, and a cancelled pool ends",
          "[raytracer][sched]") {
    struct Odd : std::runtime_error {
        using std::runtime_error::runtime_error;
    };
    class Throwing final : public processors::TileProcessor {
    public:
        int capacity() const noexcept override { return 1; }
        void submit(tiles::RenderTile) override {}
        bool wait(std::chrono::milliseconds) override { return true; }
        std::optional<tiles::TileResult> take() override { throw Odd("odd"); }
        void close() noexcept override {}
        void cancel() noexcept override {}
    };
    Job job(farm_scene());
    {
        processors::ProcessorPool pool(pool_settings(job));
        pool.add({"odd", "threads", 1, true, false, std::make_shared<Throwing>(), {}});
        pool.submit(tiles::plan_tiles(97, 53, 1, 16, core::TileOrder::kRows).front().front());
        CHECK_THROWS_AS(pool.take(), Odd);
    }
    processors::ProcessorPool pool(pool_settings(job));
    pool.submit(tiles::plan_tiles(97, 53, 1, 16, core::TileOrder::kRows).front().front());
    pool.cancel();
    CHECK_FALSE(pool.take());
}

TEST_CASE("a member that joins and fails again and again counts once", "[raytracer][sched]") {
    Job alone(farm_scene()), job(farm_scene());
    std::atomic<int> left{0};
    processors::ProcessorPool pool(counting(job, left));
    add_resting(pool);
    submit_all(pool);
    add_in_turn(pool, std::vector<std::string>(7, "host a"), left);
    add_in_turn(pool, std::vector<std::string>(7, "host b"), left);
    CHECK_FALSE(pool.wait(std::chrono::milliseconds(0)));  // an error would be an answer
    pool.add(make_threads(job, 1));
    CHECK(render_all_tiles(pool, job) == to_bytes(render_scene(alone, 1)));
}

TEST_CASE("three different members that fail at the same rows end the picture",
          "[raytracer][sched]") {
    Job job(farm_scene());
    std::atomic<int> left{0};
    processors::ProcessorPool pool(counting(job, left));
    add_resting(pool);
    submit_all(pool);
    SECTION("by names") {
        add_in_turn(pool, {"host a", "host b", "host a", "host b", "host c"}, left);
    }
    SECTION("by nothing that is known of them") {
        add_in_turn(pool, {"", "", ""}, left);
    }
    CHECK_THROWS_WITH(pool.take(), contains("3 workers failed at rows 0 to 16 of tile 0") &&
                                       contains("out of memory"));
}

TEST_CASE("three different members that fail end nothing where this process traces",
          "[raytracer][sched]") {
    Job alone(farm_scene()), job(farm_scene());
    std::atomic<int> left{0};
    processors::ProcessorPool pool(counting(job, left));
    submit_all(pool);
    const auto slow = std::make_shared<Slow>(job);
    pool.add({"here", "threads", 1, true, false, slow, {}});
    add_in_turn(pool, {"host a", "host b", "host c", "host d"}, left);
    slow->resume();
    CHECK(render_all_tiles(pool, job) == to_bytes(render_scene(alone, 1)));
}

TEST_CASE("when the last member has failed, this process continues alone", "[raytracer][sched]") {
    Job alone(farm_scene()), job(farm_scene());
    std::atomic<int> left{0};
    processors::ProcessorPool pool(counting(job, left));
    submit_all(pool);
    add_in_turn(pool, {"host a"}, left);
    CHECK(render_all_tiles(pool, job) == to_bytes(render_scene(alone, 1)));
}

TEST_CASE("what this process cannot trace either ends the picture with its error",
          "[raytracer][sched]") {
    Job job(farm_scene());
    std::atomic<int> left{0};
    processors::PoolSettings settings = counting(job, left);
    const char* says = "";
    SECTION("it fails, too") {
        class Broken final : public processors::TileProcessor {
        public:
            int capacity() const noexcept override { return 1; }
            void submit(tiles::RenderTile) override { m_given.release(); }
            bool wait(std::chrono::milliseconds) override { return true; }
            std::optional<tiles::TileResult> take() override {
                m_given.acquire();
                throw util::Error("trace: broken here, too");
            }
            void close() noexcept override {}
            void cancel() noexcept override { m_given.release(); }

        private:
            std::counting_semaphore<> m_given{0};
        };
        settings.make_checker = [] { return std::make_shared<Broken>(); };
        says = "broken here, too";
    }
    SECTION("it cannot even begin") {
        settings.make_checker = []() -> std::shared_ptr<processors::TileProcessor> {
            throw util::Error("no thread for it");
        };
        says = "no thread for it";
    }
    SECTION("it is not meant to") {
        settings.make_checker = nullptr;
        says = "all workers failed; the last error: it cannot render: out of memory";
    }
    processors::ProcessorPool pool(std::move(settings));
    submit_all(pool);
    add_in_turn(pool, {"host a"}, left);
    CHECK_THROWS_WITH(pool.take(), contains(says));
}
