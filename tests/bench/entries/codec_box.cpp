#include <zstd.h>

#include "common/util/error.hpp"
#include "common/voxel/box.hpp"
#include "tests/bench/entries/data_sets.hpp"

namespace terravox::bench::codec_box_entry {
namespace {

constexpr int kPasses = 10;

struct Boxes {
    std::vector<std::shared_ptr<const voxel::Box>> boxes;
    std::vector<std::vector<std::byte>> frames;
    double raw_bytes = 0;
    double frame_bytes = 0;
};

Boxes collect_boxes(const Context& c) {
    const OpenWorld opened = open_data_set(delft(), c, c.threads);
    Boxes out;
    for (const voxel::BoxKey& key : box_keys(*opened.world))
        if (auto box = opened.world->box(key)) {
            out.frames.push_back(voxel::compress(*box));
            out.raw_bytes += static_cast<double>(box->blob().size());
            out.frame_bytes += static_cast<double>(out.frames.back().size());
            out.boxes.push_back(std::move(box));
        }
    return out;
}

double bare_zstd_s(const Boxes& set) {
    std::vector<std::byte> blob;
    return measure_seconds([&] {
        for (int pass = 0; pass < kPasses; ++pass)
            for (const auto& frame : set.frames) {
                blob.resize(ZSTD_getFrameContentSize(frame.data(), frame.size()));
                if (ZSTD_isError(
                        ZSTD_decompress(blob.data(), blob.size(), frame.data(), frame.size())) != 0)
                    throw util::Error("decompress a box: zstd failed");
            }
    });
}

void measure_codec(const Boxes& set, Readings& readings) {
    const double compress_s = measure_seconds([&] {
        for (int pass = 0; pass < kPasses; ++pass)
            for (const auto& box : set.boxes)
                if (voxel::compress(*box).empty())
                    throw util::Error("compress a box: nothing came out");
    });
    const double decompress_s = measure_seconds([&] {
        for (int pass = 0; pass < kPasses; ++pass)
            for (const auto& frame : set.frames)
                if (voxel::decompress_box(frame, "bench")->cells().empty())
                    throw util::Error("decompress a box: nothing came out");
    });
    const double bare_s = bare_zstd_s(set);
    const double megabytes = set.raw_bytes * kPasses / 1e6;
    const double count = static_cast<double>(set.boxes.size());
    readings.add("boxes", "boxes", count);
    readings.add("raw", "kB/box", set.raw_bytes / count / 1e3);
    readings.add("compressed", "kB/box", set.frame_bytes / count / 1e3);
    readings.add("raw / compressed", "x", set.raw_bytes / set.frame_bytes);
    readings.add("compress", "MB/s", megabytes / compress_s);
    readings.add("decompress and check", "MB/s", megabytes / decompress_s);
    readings.add("decompress and check / zstd", "x", decompress_s / bare_s);
}

Entry entry() {
    Entry out;
    out.name = "codec/box";
    out.measures = "the box codec on one thread: speed in MB of raw boxes, size of a box";
    out.work = "every level-0 box of Delft (" + delft().facts + "), " + std::to_string(kPasses) +
               " times each way, zstd level 1";
    out.floor = "ZSTD_decompress of the same frames, without checksum and index check";
    out.missing = [](const Context& c) { return delft().missing(c); };
    out.prepare = [](const Context& c) -> Body {
        const auto set = std::make_shared<Boxes>(collect_boxes(c));
        return [set](Readings& readings) { measure_codec(*set, readings); };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::codec_box_entry
