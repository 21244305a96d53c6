#include "voxelserver/make/worlds/archive/remote_archive.hpp"

#include <algorithm>
#include <atomic>
#include <functional>
#include <utility>

#include "common/util/error.hpp"
#include "common/voxel/archive/archive_format.hpp"
#include "common/voxel/changed_error.hpp"
#include "voxelserver/make/worlds/archive/file_state.hpp"
#include "voxelserver/make/worlds/remote/retrying_client.hpp"

namespace terravox::worlds {
namespace {

// Opening reads the header, the facts about the world and the root of the index; small archives
// hold little more.
constexpr std::size_t kAhead_bytes = 16 << 10;

class RemoteArchive final : public voxel::archive::ByteSource {
public:
    RemoteArchive(std::string url, std::chrono::milliseconds timeout, const std::stop_token& stop,
                  const remote::HttpAccess& access)
        : m_url(std::move(url)),
          m_client(timeout, access),
          m_ending(stop, [this] { m_client.stop(); }) {
        (void)remote::HttpOrigin::of(m_url);
        remote::HttpReply first = request_range(0, kAhead_bytes);
        m_state = FileState::of(first);
        m_head = std::move(first.body);
    }

    [[nodiscard]] const std::string& name() const noexcept override { return m_url; }

    [[nodiscard]] std::span<const std::byte> read(std::uint64_t offset, std::size_t bytes,
                                                  std::vector<std::byte>& room) override {
        if (bytes == 0)
            return {};
        if (offset <= m_head.size() && bytes <= m_head.size() - offset)
            return std::span(m_head).subspan(static_cast<std::size_t>(offset), bytes);
        room = fetch(offset, bytes);
        if (room.size() != bytes)
            throw util::Error("read the box archive " + m_url + ": bytes " +
                              std::to_string(offset) + " to " + std::to_string(offset + bytes) +
                              "; it ends before");
        return room;
    }
    [[nodiscard]] std::string edition() const override { return m_state.text(); }
    void stop() noexcept override { m_client.stop(); }
    [[nodiscard]] int useful_concurrency(int threads) const noexcept override {
        constexpr int kLoaders = 8;
        return std::max(kLoaders, threads);
    }

private:
    static constexpr long kPart = 206;
    static constexpr long kOtherState = 412;
    static constexpr long kNoSuchRange = 416;

    // Fewer only at the end of the file.
    std::vector<std::byte> fetch(std::uint64_t offset, std::size_t bytes) {
        if (m_changed)
            throw changed();
        try {
            remote::HttpReply reply = request_range(offset, bytes);
            // A change is permanent: it is checked here, where no retry follows.
            if (reply.status == kOtherState || m_state.differs_from(FileState::of(reply)))
                throw changed();
            if (reply.status == kNoSuchRange)
                throw util::Error("fetch " + m_url + ": " + remote::problem_of(reply));
            return std::move(reply.body);
        } catch (const remote::WholeFileError& e) {
            FileState now = FileState::of(e.head());
            now.bytes.reset();  // its body was not read
            if (m_state.differs_from(now))
                throw changed();
            throw;
        }
    }
    remote::HttpReply request_range(std::uint64_t offset, std::size_t bytes) {
        const remote::FilePart part{
            std::to_string(offset) + "-" + std::to_string(offset + bytes - 1), m_state.condition()};
        return m_client.fetch(
            m_url, bytes, part, m_client.timeout(),
            [&](const std::string&, const remote::HttpReply& reply) {
                // A file that is smaller than the requested range may be sent whole.
                const bool whole = reply.status != kPart && reply.status != kOtherState &&
                                   reply.status != kNoSuchRange;
                if (whole && offset != 0 && !m_state.differs_from(FileState::of(reply)))
                    throw util::Error(
                        "fetch " + m_url +
                        ": the server sent the whole file where a part of it was requested");
                return reply;
            });
    }
    [[nodiscard]] voxel::ChangedError changed() {
        m_changed = true;
        return voxel::ChangedError(m_url + " has changed while it was read; start again");
    }

    const std::string m_url;
    remote::RetryingClient m_client;
    FileState m_state;  ///< from the first reply
    std::atomic<bool> m_changed{false};
    std::vector<std::byte> m_head;
    std::stop_callback<std::function<void()>> m_ending;
};

}  // namespace

std::unique_ptr<voxel::archive::ByteSource> remote_archive(const std::string& url,
                                                           std::chrono::milliseconds timeout,
                                                           const std::stop_token& stop,
                                                           const remote::HttpAccess& access) {
    return std::make_unique<RemoteArchive>(url, timeout, stop, access);
}

bool names_archive(const std::string& url) {
    return url.ends_with(voxel::archive::kEnding);
}

}  // namespace terravox::worlds
