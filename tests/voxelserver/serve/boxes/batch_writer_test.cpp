#include "voxelserver/serve/boxes/batch_writer.hpp"

#include <atomic>
#include <chrono>
#include <future>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tests/catch.hpp"

using namespace terravox;
using boxes::BatchWriter;
using Write = BatchWriter::Write;
using WhenFull = BatchWriter::WhenFull;

namespace {

constexpr BatchWriter::Limits kSmall{.queue_bytes = 100, .queue_writes = 2};

Write make_write(std::int32_t bx) {
    return {boxes::Kind::kBox, {0, bx, 0, 0}, {}, 0};
}

/// A writer that writes nothing before `opened` is set, and records its batches as text: "1 2" for
/// the items of two boxes, "row 7" for a row that is marked as used.
struct Recorder {
    explicit Recorder(const BatchWriter::Limits& limits) {
        writer.emplace(
            limits, [this] { opened.get_future().wait(); },
            [this](const std::vector<Write>& writes) { record(writes); });
    }
    void record(const std::vector<Write>& writes) {
        std::string batch;
        for (const Write& w : writes) {
            if (!batch.empty())
                batch += ' ';
            batch +=
                w.used_row != 0 ? "row " + std::to_string(w.used_row) : std::to_string(w.key.bx);
        }
        batches.push_back(batch);
    }
    std::promise<void> opened;
    std::vector<std::string> batches;   ///< to be read after flush(), or without the writer
    std::optional<BatchWriter> writer;  ///< the last member: its thread uses the others
};

}  // namespace

TEST_CASE(
    "what is queued is written in one batch, in its order, at the latest when the writer ends",
    "[voxelserver][boxes]") {
    Recorder recorder(BatchWriter::Limits{});
    CHECK(recorder.writer->put(make_write(3), 1, WhenFull::kDrop));
    recorder.writer->mark_used(7);
    CHECK(recorder.writer->put(make_write(1), 1, WhenFull::kWait));
    recorder.opened.set_value();
    recorder.writer->flush();
    CHECK(recorder.batches == std::vector<std::string>{"3 row 7 1"});
    CHECK(recorder.writer->put(make_write(2), 1, WhenFull::kDrop));
    recorder.writer.reset();
    CHECK(recorder.batches == std::vector<std::string>{"3 row 7 1", "2"});
}

TEST_CASE("flushing a writer waits for its first task", "[voxelserver][boxes]") {
    std::atomic<bool> started{false};
    BatchWriter writer({}, [&] { started = true; }, [](const std::vector<Write>&) {});
    writer.flush();
    CHECK(started);
}

TEST_CASE("a full queue drops items, and has room again once they are written",
          "[voxelserver][boxes]") {
    Recorder recorder(kSmall);
    CHECK_FALSE(recorder.writer->put(make_write(1), 101, WhenFull::kDrop));
    CHECK(recorder.writer->put(make_write(2), 60, WhenFull::kDrop));
    CHECK_FALSE(recorder.writer->put(make_write(3), 41, WhenFull::kDrop));
    CHECK(recorder.writer->put(make_write(4), 40, WhenFull::kDrop));
    recorder.opened.set_value();
    recorder.writer->flush();
    CHECK(recorder.writer->put(make_write(5), 100, WhenFull::kDrop));
    recorder.writer->flush();
    CHECK(recorder.batches == std::vector<std::string>{"2 4", "5"});
}

TEST_CASE("an item that waits for room in the queue is written in a later batch",
          "[voxelserver][boxes]") {
    Recorder recorder(kSmall);
    // Larger than the limit, but the queue is empty.
    CHECK(recorder.writer->put(make_write(1), 1000, WhenFull::kWait));
    bool queued = false;
    std::thread waiting(
        [&] { queued = recorder.writer->put(make_write(2), 1000, WhenFull::kWait); });
    recorder.opened.set_value();
    waiting.join();
    CHECK(queued);
    recorder.writer->flush();
    CHECK(recorder.batches == std::vector<std::string>{"1", "2"});
}

TEST_CASE("rows are marked as used only while the queue is short", "[voxelserver][boxes]") {
    Recorder recorder(kSmall);
    for (std::int64_t row = 1; row <= 5; ++row)
        recorder.writer->mark_used(row);
    CHECK(recorder.writer->put(make_write(1), 100, WhenFull::kDrop));
    recorder.opened.set_value();
    recorder.writer->flush();
    CHECK(recorder.batches == std::vector<std::string>{"row 1 row 2 row 3 1"});
}

TEST_CASE("a writer without work writes empty batches", "[voxelserver][boxes]") {
    std::atomic<int> empty{0};
    const BatchWriter writer(
        {.idle = std::chrono::milliseconds(1)}, [] {},
        [&](const std::vector<Write>& writes) { empty += writes.empty(); });
    while (empty < 2)
        std::this_thread::yield();
    CHECK(empty >= 2);
}
