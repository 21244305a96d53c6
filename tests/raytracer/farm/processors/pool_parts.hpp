#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "raytracer/farm/processors/pool_members.hpp"

namespace terravox::test {

using PoolTime = processors::LeaseBook::Time;

/// A time of tests: so many seconds after its beginning.
inline PoolTime at_s(double seconds) {
    return PoolTime{} +
           std::chrono::duration_cast<PoolTime::duration>(std::chrono::duration<double>(seconds));
}

/// A processor that never has to compute anything.
class NullProcessor final : public processors::TileProcessor {
public:
    explicit NullProcessor(int capacity = 1000) : m_capacity(capacity) {}
    int capacity() const noexcept override { return m_capacity; }
    void submit(tiles::RenderTile) override {}
    bool wait(std::chrono::milliseconds) override { return false; }
    std::optional<tiles::TileResult> take() override { return std::nullopt; }
    void close() noexcept override {}
    void cancel() noexcept override {}

private:
    int m_capacity;
};

/// A worker with one thread, which is not trusted.
inline processors::MemberSpec worker_spec(int capacity = 1000) {
    processors::MemberSpec out;
    out.name = "worker";
    out.kind = "socket";
    out.processor = std::make_shared<NullProcessor>(capacity);
    return out;
}

/// One thread of this process, which is trusted.
inline processors::MemberSpec trusted_spec() {
    processors::MemberSpec out = worker_spec();
    out.name = "here";
    out.kind = "threads";
    out.trusted = true;
    return out;
}

/// Makes the speed of a new member known, with one second of work before `end`.
inline void set_speed(processors::PoolMember& member, std::size_t pixels_per_s, PoolTime end) {
    const PoolTime begin = end - std::chrono::seconds(1);
    member.on_lease(begin);
    member.on_answer(0);
    member.count_time(end);
    member.on_answer(pixels_per_s);
    member.on_idle(end);
}

/// A tile of 64 pixels a row.
inline tiles::RenderTile tile_of_rows(std::uint32_t index, int rows) {
    tiles::RenderTile out;
    out.index = index;
    out.x1 = 64;
    out.y1 = rows;
    return out;
}

/// The pixels that every honest member computes of a band: a function of the place.
/// @param error  what the others add to them
inline tiles::TileResult computed(const tiles::RenderTile& band, float error = 0) {
    tiles::TileResult out;
    out.tile = band;
    band.each_pixel([&](int x, int y) {
        tiles::PixelSample sample;
        sample.colour = {static_cast<float>(x), static_cast<float>(y), error};
        sample.alpha = 1;
        sample.depth_m = static_cast<float>(x + y);
        out.samples.push_back(sample);
    });
    return out;
}

}  // namespace terravox::test
