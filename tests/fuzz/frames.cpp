// Frames between a coordinator and a worker: pieces, the hello, and what each kind carries.
// The input is a row of gRPC's messages, each behind its length (two bytes, little-endian).
#include <deque>
#include <optional>
#include <utility>

#include "common/voxel/box.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/farm/net/stream.hpp"
#include "raytracer/farm/wire/frames.hpp"
#include "raytracer/farm/wire/picture_spec.hpp"
#include "tests/fuzz/tile_bytes.hpp"

namespace terravox::fuzz {
namespace {

std::deque<grpc::ByteBuffer> make_messages(Input input) {
    std::deque<grpc::ByteBuffer> out;
    while (input.size() >= 2) {
        const std::size_t claimed = input[0] | std::size_t{input[1]} << 8;
        const Input message = input.subspan(2, std::min(claimed, input.size() - 2));
        const grpc::Slice slice(message.data(), message.size());
        out.emplace_back(&slice, 1);
        input = input.subspan(2 + message.size());
    }
    return out;
}

/// A peer that has said all that it will ever say. What is sent to it is dropped.
class SaidStream final : public net::Stream {
public:
    explicit SaidStream(std::deque<grpc::ByteBuffer> messages)
        : Stream("the input"), m_messages(std::move(messages)) {}

    /// Takes the place of gRPC's threads: finishes the reads and writes that were begun, one after
    /// the other.
    void feed() {
        begin();
        while (m_into != nullptr && !m_messages.empty()) {
            *std::exchange(m_into, nullptr) = m_messages.front();
            m_messages.pop_front();
            read_done(true, "");
        }
        if (std::exchange(m_into, nullptr) != nullptr)
            read_done(false, "it has said all");
        ended("it has said all");
        done();
    }

private:
    void start_read(grpc::ByteBuffer* into) override { m_into = into; }
    void start_write(const grpc::ByteBuffer*) override {}
    void end_writes() override {}
    void cancel() override {}
    void let_go() override {}

    std::deque<grpc::ByteBuffer> m_messages;
    grpc::ByteBuffer* m_into = nullptr;
};

/// What comes of a first frame.
class FirstFrame final : public net::Link {
public:
    explicit FirstFrame(farm::Frame frame) : m_frame(std::move(frame)) {}
    bool send(farm::Frame) override { return true; }
    std::optional<farm::Frame> receive() override { return std::exchange(m_frame, std::nullopt); }
    void close(std::chrono::milliseconds) noexcept override {}
    void abort() noexcept override {}
    const std::string& peer() const noexcept override { return m_peer; }
    std::string why_ended() const override { return {}; }
    Traffic traffic() const noexcept override { return {}; }

private:
    std::optional<farm::Frame> m_frame;
    const std::string m_peer = "the input";
};

void take_tile(const std::string& result) {
    Editable tile(Input(reinterpret_cast<const std::uint8_t*>(result.data()), result.size()));
    put_tile_checksum(tile, 0, result.size());
    const tiles::TileHead head = tiles::read_tile_head(tile.bytes(), "the input");
    if (head.pixels <= 64 * 64)
        (void)tiles::decode_tile(tile.bytes(), "the input");
}

void take(const farm::Frame& frame) {
    switch (frame.what_case()) {
        case farm::Frame::kHello: {
            FirstFrame link(frame);
            (void)farm::meet(link, farm::make_hello({}), {farm::WORKER, farm::OBSERVER},
                             std::chrono::minutes(1));
            break;
        }
        case farm::Frame::kState: {
            allow_errors([&] { (void)farm::unpack_scene(frame.state().content()); });
            allow_errors(
                [&] { (void)voxel::world_from_json(frame.state().content(), "the input"); });
            break;
        }
        case farm::Frame::kTask:
            for (const auto& tile : frame.task().tiles())
                (void)from_frame(tile);
            break;
        case farm::Frame::kDone: take_tile(frame.done().result()); break;
        case farm::Frame::kBox: {
            const std::string& bytes = frame.box().frame();
            (void)voxel::decompress_box(std::as_bytes(std::span(bytes)), "the input");
            break;
        }
        default: break;
    }
}

}  // namespace

void run(Input input) {
    SaidStream stream(make_messages(input));
    stream.feed();
    while (const auto frame = stream.receive())
        allow_errors([&] { take(*frame); });
}

}  // namespace terravox::fuzz
