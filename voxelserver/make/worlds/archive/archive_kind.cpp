#include "voxelserver/make/worlds/archive/archive_kind.hpp"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <functional>
#include <string_view>
#include <utility>

#include "common/util/error.hpp"
#include "common/voxel/archive/archive_format.hpp"
#include "common/voxel/archive/archive_reader.hpp"
#include "common/voxel/archive/byte_source.hpp"
#include "common/voxel/fingerprint.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"
#include "voxelserver/make/worlds/remote/http_access.hpp"
#include "voxelserver/make/worlds/remote/retrying_client.hpp"

namespace terravox::worlds {
namespace {

constexpr std::string_view kWeak = "W/";

bool is_weak(const std::string& etag) noexcept {
    return etag.starts_with(kWeak);
}

/// The part of a tag that weak comparison uses: weak and strong tags of the same text are the same.
std::string_view opaque(const std::string& etag) noexcept {
    return std::string_view(etag).substr(is_weak(etag) ? kWeak.size() : 0);
}

bool is_etag(const std::string& text) noexcept {
    constexpr std::size_t kQuotes = 2;
    if (text.size() > FileState::kMaxEtag_bytes)
        return false;
    const std::string_view tag = opaque(text);
    if (tag.size() < kQuotes || tag.front() != '"' || tag.back() != '"')
        return false;
    const auto fits = [](char c) { return c > ' ' && c < '\x7f' && c != '"'; };
    return std::all_of(tag.begin() + 1, tag.end() - 1, fits);
}

/// "Sun, 06 Nov 1994 08:49:37 GMT", the only form that servers may send.
bool is_date(const std::string& text) noexcept {
    constexpr std::string_view kForm = "Aaa, 00 Aaa 0000 00:00:00 GMT";
    const auto fits = [](char form, char c) {
        if (form == 'A')
            return c >= 'A' && c <= 'Z';
        if (form == 'a')
            return c >= 'a' && c <= 'z';
        if (form == '0')
            return c >= '0' && c <= '9';
        return form == c;
    };
    return std::equal(kForm.begin(), kForm.end(), text.begin(), text.end(), fits);
}

/// Of "bytes 0-99/1234", and of the "bytes */1234" of an unsatisfiable range.
std::optional<std::uint64_t> whole_size(std::string_view range) noexcept {
    const auto slash = range.rfind('/');
    if (!range.starts_with("bytes ") || slash == std::string_view::npos)
        return std::nullopt;
    const std::string_view number = range.substr(slash + 1);
    std::uint64_t size = 0;
    const auto read = std::from_chars(number.data(), number.data() + number.size(), size);
    if (read.ec != std::errc{} || read.ptr != number.data() + number.size())
        return std::nullopt;
    return size;
}

}  // namespace

FileState FileState::of(const remote::HttpReply& reply) {
    FileState out;
    if (is_etag(reply.etag))
        out.etag = reply.etag;
    if (is_date(reply.last_modified))
        out.last_modified = reply.last_modified;
    constexpr long kWhole = 200;
    out.bytes = reply.status == kWhole ? reply.body.size() : whole_size(reply.content_range);
    return out;
}

std::string FileState::condition() const {
    if (!etag.empty() && !is_weak(etag))
        return "If-Match: " + etag;
    if (!last_modified.empty())
        return "If-Unmodified-Since: " + last_modified;
    return {};
}

bool FileState::differs_from(const FileState& later) const {
    if (bytes && later.bytes && *bytes != *later.bytes)
        return true;
    if (!etag.empty() && !later.etag.empty())
        return opaque(etag) != opaque(later.etag);
    if (!last_modified.empty() && !later.last_modified.empty())
        return last_modified != later.last_modified;
    return !etag.empty() || !last_modified.empty();
}

std::string FileState::text() const {
    std::string out = !etag.empty() ? etag : last_modified;
    if (bytes)
        out += (out.empty() ? "" : ", ") + std::to_string(*bytes) + " bytes";
    return out;
}

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
            throw util::Error("read the box archive {}: bytes {} to {}; it ends before", m_url,
                              offset, offset + bytes);
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
                throw util::Error("fetch {}: {}", m_url, remote::find_problem(reply));
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
                        "fetch {}: the server sent the whole file where a part of it was requested",
                        m_url);
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

namespace {

bool is_file_of_boxes(const std::string& input) {
    return voxel::is_archive(input);
}

bool is_address_of_archive(const std::string& input) {
    return is_http_address(input) && names_archive(input);
}

voxel::Fingerprint state_of_file(const WorldOptions& options) {
    return voxel::file_identity(options.inputs.front(), "box archive");
}

std::unique_ptr<voxel::World> open_file(const OpenRequest& request) {
    return voxel::open_archive(voxel::archive::file_source(request.input()));
}

std::unique_ptr<voxel::World> open_remote(const OpenRequest& request) {
    return voxel::open_archive(remote_archive(request.input(), request.options.box_timeout,
                                              request.stop, remote::access_of_environment()));
}

}  // namespace

constinit const WorldKind kArchiveKind{
    .noun = "a box archive",
    .input = "a box archive (.tvx)",
    .recognises = is_file_of_boxes,
    .open = open_file,
    .state = state_of_file,
    .is_archive = true,
    .keeps_its_files = true,
};

constinit const WorldKind kRemoteArchiveKind{
    .noun = "the address of a box archive",
    .input = {},
    .recognises = is_address_of_archive,
    .open = open_remote,
    .flags = "--processing-box-timeout-s",
    .is_path = false,
    .is_archive = true,
    .farm_access = FarmAccess::kByAddress,
};

}  // namespace terravox::worlds
