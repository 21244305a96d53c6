#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <list>
#include <thread>

#include "common/thread/tsan_order.hpp"
#include "common/util/log.hpp"
#include "raytracer/farm/net/auth_acceptor.hpp"
#include "raytracer/farm/net/certificates.hpp"
#include "raytracer/farm/net/credentials.hpp"
#include "raytracer/farm/net/endpoint.hpp"
#include "raytracer/farm/net/farm.grpc.pb.h"
#include "raytracer/farm/net/grpc_settings.hpp"
#include "raytracer/farm/net/stream.hpp"

namespace terravox::net {

RefusalLog::RefusalLog(std::function<void(const std::string&)> say, std::string what)
    : m_say(std::move(say)), m_what(std::move(what)) {
    if (!m_say)
        m_say = [](const std::string& line) { util::log_warn("{}", line); };
}

void RefusalLog::refused(const std::string& who, const std::string& peer, const std::string& why,
                         Clock::time_point now) {
    auto key = std::pair(who, why);
    if (!m_reported.contains(key) && m_reported.size() >= kMaxKept) {
        if (now - m_cleared >= std::chrono::seconds(1)) {
            std::erase_if(m_reported,
                          [&](const auto& one) { return now - one.second.when >= kQuiet; });
            m_cleared = now;
        }
        if (m_reported.size() >= kMaxKept)
            key = {};
    }
    const auto [reported, first] = m_reported.try_emplace(key);
    if (!first && now - reported->second.when < kQuiet) {
        ++reported->second.since;
        return;
    }
    std::string line = m_what + " " + peer + ": " + why;
    if (reported->second.since > 0)
        line += " (and " + std::to_string(reported->second.since) + " more since, from " +
                (key.first.empty() ? "other addresses" : key.first) + ")";
    reported->second = {now, 0};
    m_say(line);
}

namespace {

/// The end that was dialled. gRPC requires Finish exactly once, and nothing started after it: it
/// may call OnDone at any time from then on, and would continue with what was started later when
/// this is destroyed.
class AcceptedStream final : public Stream,
                             public std::enable_shared_from_this<AcceptedStream>,
                             public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
public:
    AcceptedStream(grpc::CallbackServerContext* context, std::string peer,
                   std::function<void()> when_done)
        : Stream(std::move(peer)), m_context(context), m_when_done(std::move(when_done)) {}
    using Stream::set_certified;

    void start() {
        m_self = shared_from_this();
        m_context->AddInitialMetadata(kAcceptedKey, "1");
        StartSendInitialMetadata();
        begin();
    }

private:
    void start_read(grpc::ByteBuffer* into) override { StartRead(into); }
    void start_write(const grpc::ByteBuffer* frame) override { StartWrite(frame); }
    void end_writes() override { finish(grpc::Status::OK); }
    void cancel() override { m_context->TryCancel(); }
    void let_go() override { finish(grpc::Status::OK); }
    void finish(const grpc::Status& status) {
        if (std::exchange(m_finished, true))
            return;
        end_reads();
        Finish(status);
    }

    void OnReadDone(bool ok) override {
        read_done(ok, m_context->IsCancelled() ? kLost : "the other end closed it");
    }
    void OnWriteDone(bool ok) override { write_done(ok); }
    void OnCancel() override { ended(kLost); }
    void OnDone() override {
        const auto self = std::move(m_self);
        const auto when_done = std::move(m_when_done);
        done();
        when_done();
    }

    static constexpr const char* kLost =
        "the connection was lost, or the other end ended it at once";
    grpc::CallbackServerContext* m_context;
    std::function<void()> m_when_done;
    std::shared_ptr<AcceptedStream> m_self;
    bool m_finished = false;
};

/// Accepts a call only to send the reason of its refusal.
class RefusedCall final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
public:
    explicit RefusedCall(const std::string& why) {
        Finish({grpc::StatusCode::PERMISSION_DENIED, why});
    }
    void OnDone() override { delete this; }
};

}  // namespace

/// Three kinds of threads: the acceptor's, gRPC's own few, and one for each call of on_link.
///
/// The mutex guards the hosts (one for each accepted link) and the count of streams that gRPC has
/// not released. on_link runs without it. A host whose thread has ended is joined when the next
/// link is accepted, or by stop().
class Listener::Impl final : private farm::Farm::WithRawCallbackMethod_Join<farm::Farm::Service> {
public:
    Impl(const sockets::Address& address, const Credentials& credentials, OnLink on_link,
         const ListenerLimits& limits)
        : m_on_link(std::move(on_link)), m_tls(credentials.tls()), m_ca(credentials.ca) {
        begin_grpc();
        check(credentials);
        grpc::ServerBuilder builder;
        set_up(builder, Keepalive::of_environment(), limits.handshake);
        m_acceptor = builder.experimental().AddExternalConnectionAcceptor(
            grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
            m_tls ? to_listen(read_pem(credentials)) : grpc::InsecureServerCredentials());
        builder.RegisterService(this);
        m_server = builder.BuildAndStart();
        if (!m_server)
            throw util::Error("listen at " + address.text() + ": gRPC does not start");
        try {
            m_door.emplace(address, credentials, limits,
                           [this](sockets::Socket socket, const std::string&) {
                               hand_over(std::move(socket));
                           });
            m_door->start();
        } catch (...) {
            m_server->Shutdown();
            throw;
        }
    }
    ~Impl() override { stop(); }

    [[nodiscard]] std::uint16_t port() const noexcept { return m_door->port(); }

    void stop() noexcept {
        m_door->stop();
        {
            const std::lock_guard lock(m_mutex);
            m_stopping = true;
            for (auto& host : m_hosts)
                if (const auto stream = host.stream.lock())
                    stream->abort();
        }
        // Data that links sent before they were closed still goes out; peers that do not leave by
        // themselves are cut off.
        m_server->Shutdown(std::chrono::system_clock::now() + std::chrono::milliseconds(500));
        std::list<Host> hosts;
        {
            std::unique_lock lock(m_mutex);
            m_changed.wait(lock, [&] { return m_streams == 0; });
            hosts.splice(hosts.end(), m_hosts);
        }
        for (auto& host : hosts)
            host.thread.join();
    }

private:
    struct Host {
        std::weak_ptr<Stream> stream;
        std::thread thread;
        bool ended = false;
    };

    void hand_over(sockets::Socket socket) {
        grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
        parameters.fd = socket.release();
        m_handed_over.precede();
        m_acceptor->HandleNewConnection(&parameters);
    }

    grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* Join(
        grpc::CallbackServerContext* context) override {
        m_handed_over.follow();
        const std::string peer = readable_peer(context->peer());
        const auto number = m_door->joined(peer);
        if (!number)
            return new RefusedCall("this connection has carried a call before");
        Certified certified;
        std::string why;
        try {
            if (m_tls)
                certified = certified_peer(*context->auth_context(), m_ca);
        } catch (const util::Error& e) {
            why = e.what();
        }
        if (!why.empty()) {
            m_door->log_refusal(peer, why);
            m_door->left(peer, *number);
            return new RefusedCall(why);
        }
        std::list<Host> ended;
        const std::lock_guard lock(m_mutex);
        if (m_stopping) {
            m_door->left(peer, *number);
            return new RefusedCall("the listener stops");
        }
        for (auto host = m_hosts.begin(); host != m_hosts.end();) {
            const auto next = std::next(host);
            if (host->ended)
                ended.splice(ended.end(), m_hosts, host);
            host = next;
        }
        for (auto& host : ended)
            host.thread.join();  // it is about to end
        const auto stream = std::make_shared<AcceptedStream>(
            context, peer, [this, peer, number = *number] { stream_done(peer, number); });
        if (m_tls)
            stream->set_certified(std::move(certified), m_ca);
        auto& host = m_hosts.emplace_back();
        host.stream = stream;
        try {
            host.thread = std::thread([this, &host, stream] { run(host, stream); });
        } catch (const std::system_error& e) {
            m_hosts.pop_back();
            m_door->log_refusal(peer, std::string("no thread for it: ") + e.what());
            m_door->left(peer, *number);
            return new RefusedCall("the listener has no thread for another link now");
        }
        ++m_streams;
        stream->start();
        return stream.get();
    }

    void run(Host& host, std::shared_ptr<Stream> stream) noexcept {
        try {
            m_on_link(std::make_unique<StreamLink>(std::move(stream)));
        } catch (const std::exception& e) {
            util::log_error("farm: serve a link: {}", e.what());
        }
        const std::lock_guard lock(m_mutex);
        host.ended = true;
    }

    void stream_done(const std::string& peer, std::uint64_t number) {
        m_door->left(peer, number);
        const std::lock_guard lock(m_mutex);
        --m_streams;
        m_changed.notify_all();
    }

    const OnLink m_on_link;
    const bool m_tls;
    const std::filesystem::path m_ca;
    std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> m_acceptor;
    thread::TsanOrder m_handed_over;  ///< before the call of a connection, by way of gRPC
    std::unique_ptr<grpc::Server> m_server;
    std::optional<AuthAcceptor> m_door;
    std::mutex m_mutex;
    std::condition_variable m_changed;
    std::list<Host> m_hosts;
    int m_streams = 0;
    bool m_stopping = false;
};

Listener::Listener(const sockets::Address& address, const Credentials& credentials, OnLink on_link,
                   const ListenerLimits& limits)
    : m_impl(std::make_unique<Impl>(address, credentials, std::move(on_link), limits)) {}
Listener::~Listener() = default;
std::uint16_t Listener::port() const noexcept {
    return m_impl->port();
}
void Listener::stop() noexcept {
    m_impl->stop();
}

}  // namespace terravox::net
