#include <grpcpp/create_channel.h>
#include <grpcpp/create_channel_posix.h>
#include <grpcpp/generic/generic_stub.h>

#include <algorithm>
#include <array>

#include "raytracer/farm/net/certificates.hpp"
#include "raytracer/farm/net/credentials.hpp"
#include "raytracer/farm/net/grpc_settings.hpp"
#include "raytracer/farm/net/handshake.hpp"
#include "raytracer/farm/net/stream.hpp"
#include "voxelserver/serve/sockets/socket.hpp"

namespace terravox::net {
namespace {

using Clock = std::chrono::steady_clock;

std::string to_text(const grpc::Status& status) {
    if (status.ok())
        return "the other end closed it";
    return status.error_message().empty() ? "gRPC status " + std::to_string(status.error_code())
                                          : status.error_message();
}

/// The end that dialled. A hold keeps gRPC from calling OnDone while send() may still start a
/// write.
///
/// It owns a channel, and destroying the last channel of a process ends gRPC's threads and waits
/// for them, so it must not be destroyed on one of those. Therefore gRPC has no share in its
/// ownership: its creator waits for the end of the call, and is the last to use it.
class DialledStream final : public Stream,
                            private grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
public:
    /// @param ca file of the CA's certificate; empty: with a token
    DialledStream(std::shared_ptr<grpc::Channel> channel, std::string peer,
                  std::filesystem::path ca)
        : Stream(std::move(peer)), m_channel(std::move(channel)), m_ca(std::move(ca)) {}

    void start() {
        grpc::TemplatedGenericStub<grpc::ByteBuffer, grpc::ByteBuffer> stub(m_channel);
        stub.PrepareBidiStreamingCall(&m_context, kJoinMethod, {}, this);
        AddHold();
        StartCall();
        begin();
    }

    /// Waits until the listener's end accepts the call.
    /// @return nullopt: success; else the reason, or OK on timeout
    std::optional<grpc::Status> wait_until_taken(Clock::time_point deadline) {
        std::unique_lock lock(m_taken_mutex);
        m_taken_changed.wait_until(lock, deadline, [&] { return m_taken || m_status; });
        if (m_taken)
            return std::nullopt;
        return m_status ? *m_status : grpc::Status::OK;
    }

private:
    void start_read(grpc::ByteBuffer* into) override { StartRead(into); }
    void start_write(const grpc::ByteBuffer* frame) override { StartWrite(frame); }
    void end_writes() override { StartWritesDone(); }
    void cancel() override { m_context.TryCancel(); }
    void let_go() override { RemoveHold(); }

    void OnReadInitialMetadataDone(bool ok) override {
        if (!ok || !m_context.GetServerInitialMetadata().contains(kAcceptedKey))
            return;
        const std::lock_guard lock(m_taken_mutex);
        try {
            if (!m_ca.empty())
                set_certified(certified_peer(*m_context.auth_context(), m_ca), m_ca);
        } catch (const util::Error& e) {
            m_status = grpc::Status(grpc::StatusCode::PERMISSION_DENIED, e.what());
            m_taken_changed.notify_all();
            return;
        }
        if (m_peer.empty())
            m_peer = readable_peer(m_context.peer());
        m_taken = true;
        m_taken_changed.notify_all();
    }
    void OnReadDone(bool ok) override { read_done(ok, nullptr); }
    void OnWriteDone(bool ok) override { write_done(ok); }
    void OnDone(const grpc::Status& status) override {
        ended(to_text(status));
        {
            const std::lock_guard lock(m_taken_mutex);
            if (!m_status)
                m_status = status;
            m_taken_changed.notify_all();
        }
        done();
    }

    std::shared_ptr<grpc::Channel> m_channel;
    const std::filesystem::path m_ca;
    grpc::ClientContext m_context;
    std::mutex m_taken_mutex;
    std::condition_variable m_taken_changed;
    bool m_taken = false;
    std::optional<grpc::Status> m_status;
};

/// @return a link once the listener's end has accepted the call; else the error
struct Attempt {
    std::unique_ptr<Link> link;
    grpc::Status status;  ///< OK: no answer in time
};
Attempt join(std::shared_ptr<grpc::Channel> channel, const std::string& peer,
             const std::filesystem::path& ca, Clock::time_point deadline) {
    const auto stream = std::make_shared<DialledStream>(std::move(channel), peer, ca);
    auto link = std::make_unique<StreamLink>(stream);
    stream->start();
    if (auto status = stream->wait_until_taken(deadline))
        return {nullptr, *status};
    return {std::move(link), grpc::Status::OK};
}

std::unique_ptr<Link> dial_with_token(const sockets::Endpoint& endpoint, const std::string& token,
                                      Clock::time_point deadline) {
    sockets::Socket socket = sockets::connect_to(endpoint, deadline);
    DiallerHandshake handshake(token);
    const auto write = [&](const Bytes& bytes) {
        sockets::write_all(socket.fd(), bytes.data(), bytes.size(), deadline);
    };
    const auto keepalive = Keepalive::of_environment();
    std::array<std::byte, kHello_bytes> hello{};
    std::array<std::byte, kAnswer_bytes> answer{};
    const std::string attempt = "connect to " + endpoint.text() + ": ";
    try {
        write(handshake.hello());
        sockets::read_exactly(socket.fd(), hello.data(), hello.size(), deadline);
        write(handshake.prove(hello));
        sockets::read_exactly(socket.fd(), answer.data(), answer.size(), deadline);
        handshake.check(answer);
    } catch (const RefusedError& e) {
        throw RefusedError(attempt + e.what());
    } catch (const util::Error& e) {
        throw util::Error(attempt + e.what());
    }
    sockets::tune(socket.fd(), keepalive.silence + keepalive.answer);
    auto [link, status] = join(grpc::CreateCustomInsecureChannelFromFd(
                                   "terravox-farm", socket.release(), channel_arguments(keepalive)),
                               endpoint.text(), {}, deadline);
    if (!link)
        throw util::Error(
            attempt + (status.ok() ? "no answer in time after the handshake" : to_text(status)));
    return std::move(link);
}

/// The reason that gRPC reports for a failed connection with certificates, and whether another try
/// is worthwhile. Only gRPC's message text is available.
std::pair<std::string, bool> to_refusal(const grpc::Status& status, const std::string& endpoint) {
    std::string why = to_text(status);
    if (status.error_code() != grpc::StatusCode::UNAVAILABLE)
        return {why, true};
    if (const auto at = why.rfind(endpoint + ": "); at != std::string::npos)
        why.erase(0, at + endpoint.size() + 2);
    // With TLS 1.3 the listener checks the dialler's certificate after the dialler considers the
    // handshake complete. A slow listener closes in the same way, so another try is worthwhile.
    if (why.find("Socket closed") != std::string::npos)
        return {"it closed the connection when it had seen the certificate, or was too slow",
                false};
    for (const char* word : {"certificate", "alert", "wrong version number"})
        if (why.find(word) != std::string::npos)
            return {why, true};
    return {why, false};
}

std::unique_ptr<Link> dial_with_certificate(const sockets::Endpoint& endpoint, const Pem& pem,
                                            const std::filesystem::path& ca,
                                            Clock::time_point deadline) {
    auto arguments = channel_arguments(Keepalive::of_environment());
    arguments.SetSslTargetNameOverride(std::string(kFarmName));
    const auto left_ms = std::max<long long>(
        1, std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count());
    // Also the time limit of an attempt.
    arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS,
                     static_cast<int>(std::min<long long>(left_ms, 3'600'000)));
    const std::string target =
        (endpoint.storage.ss_family == AF_INET6 ? "ipv6:" : "ipv4:") + endpoint.text();
    auto [link, status] =
        join(grpc::CreateCustomChannel(target, to_dial(pem), arguments), "", ca, deadline);
    if (link)
        return std::move(link);
    const std::string attempt = "connect to " + endpoint.text() + ": ";
    if (status.ok())
        throw util::Error(attempt + "no answer in time");
    const auto [why, for_good] = to_refusal(status, endpoint.text());
    if (for_good)
        throw RefusedError(attempt + why);
    throw util::Error(attempt + why);
}

}  // namespace

std::unique_ptr<Link> dial(const sockets::Address& address, const Credentials& credentials,
                           std::chrono::milliseconds timeout) {
    begin_grpc();
    check(credentials);
    const auto pem = credentials.tls() ? std::optional(read_pem(credentials)) : std::nullopt;
    const auto deadline = Clock::now() + timeout;
    const auto endpoints = sockets::resolve(address, false);
    std::string why;
    for (std::size_t i = 0; i < endpoints.size(); ++i) {
        // An address of the name that drops packets leaves time for the others.
        const auto now = Clock::now();
        const auto until = now + (deadline - now) / static_cast<long>(endpoints.size() - i);
        try {
            return pem ? dial_with_certificate(endpoints[i], *pem, credentials.ca, until)
                       : dial_with_token(endpoints[i], credentials.token, until);
        } catch (const RefusedError&) {
            throw;
        } catch (const util::Error& e) {
            why += (why.empty() ? "" : "; ") + std::string(e.what());
        }
    }
    throw util::Error(why);
}

}  // namespace terravox::net
