#include "raytracer/world/far_archive.hpp"

#include <algorithm>
#include <functional>

#include "common/util/error.hpp"
#include "common/voxel/archive/archive_format.hpp"
#include "raytracer/world/patient_client.hpp"

namespace terravox {
namespace {

// Opening asks for the header, the facts about the world and the root of the index; small archives hold little more.
constexpr std::size_t kAhead_bytes = 16 << 10;

class FarArchive final : public voxel::archive::ByteSource {
public:
    FarArchive(std::string url, std::chrono::milliseconds patience, const std::stop_token& stop,
               const HttpAccess& access)
        : m_url(std::move(url)),
          m_client(patience, access),
          m_ending(stop, [this] { m_client.stop(); }) {
        (void)HttpOrigin::of(m_url);
        m_head = fetch(0, kAhead_bytes);
    }

    [[nodiscard]] const std::string& name() const noexcept override { return m_url; }

    [[nodiscard]] std::span<const std::byte> read(std::uint64_t offset, std::size_t bytes, std::vector<std::byte>& room) override {
        if (bytes == 0) return {};
        if (offset <= m_head.size() && bytes <= m_head.size() - offset) return std::span(m_head).subspan(static_cast<std::size_t>(offset), bytes);
        room = fetch(offset, bytes);
        if (room.size() != bytes)
            throw Error("read the box archive " + m_url + ": bytes " + std::to_string(offset) + " to " + std::to_string(offset + bytes) + "; it ends before");
        return room;
    }
    void stop() noexcept override { m_client.stop(); }
    [[nodiscard]] int worth_asking(int threads) const noexcept override {
        constexpr int kLoaders = 8;
        return std::max(kLoaders, threads);
    }

private:
    // Fewer only at the end of the file.
    std::vector<std::byte> fetch(std::uint64_t offset, std::size_t bytes) {
        const std::string range = std::to_string(offset) + "-" + std::to_string(offset + bytes - 1);
        return m_client.ask(m_url, bytes, range, m_client.patience(), [&](const std::string&, const HttpReply& reply) {
            // A file that is smaller than what was asked for may come whole.
            if (reply.status != 206 && offset != 0) throw Error("fetch " + m_url + ": the server sent the whole file where a part of it was asked for");
            return reply.body;
        });
    }

    const std::string m_url;
    PatientClient m_client;
    std::vector<std::byte> m_head;
    std::stop_callback<std::function<void()>> m_ending;
};

}  // namespace

std::unique_ptr<voxel::archive::ByteSource> far_archive(const std::string& url,
                                                        std::chrono::milliseconds patience,
                                                        const std::stop_token& stop,
                                                        const HttpAccess& access) {
    return std::make_unique<FarArchive>(url, patience, stop, access);
}

bool names_archive(const std::string& url) { return url.ends_with(voxel::archive::kEnding); }

}  // namespace terravox
