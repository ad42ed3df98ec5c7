#pragma once
#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace nepho::test {

/// A web server on this machine for as long as it lives: one thread per request, ranges honoured.
class HttpServer {
 public:
  struct Answer {
    int status = 200;
    std::string body = {};
    bool silent = false;  ///< says nothing until the server ends
  };
  using Handler = std::function<Answer(const std::string& path)>;

  explicit HttpServer(Handler handler) : handler_(std::move(handler)), listener_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    REQUIRE(bind(listener_, reinterpret_cast<sockaddr*>(&address), size) == 0);
    REQUIRE(listen(listener_, 64) == 0);
    REQUIRE(getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) == 0);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { accept_all(); });
  }
  ~HttpServer() {
    ended_ = true;
    thread_.join();
    for (std::thread& worker : workers_) worker.join();
    close(listener_);
  }
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;
  /// "http://127.0.0.1:4711"
  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_); }
  std::vector<std::string> asked() const {
    const std::lock_guard lock(mutex_);
    return asked_;
  }

 private:
  void accept_all() {
    while (!ended_) {
      pollfd waiting{listener_, POLLIN, 0};
      if (poll(&waiting, 1, 20) <= 0) continue;
      const int client = accept(listener_, nullptr, nullptr);
      if (client >= 0) workers_.emplace_back([this, client] { serve(client); });
    }
  }
  void serve(int client) {
    std::string request;
    char buffer[4096];
    while (!ended_ && request.find("\r\n\r\n") == std::string::npos) {
      pollfd waiting{client, POLLIN, 0};
      if (poll(&waiting, 1, 20) <= 0) continue;
      const ssize_t got = recv(client, buffer, sizeof(buffer), 0);
      if (got <= 0) break;
      request.append(buffer, static_cast<size_t>(got));
    }
    const size_t first = request.find(' '), second = request.find(' ', first + 1);
    if (second != std::string::npos) answer(client, request, request.substr(first + 1, second - first - 1));
    shutdown(client, SHUT_RDWR);
    close(client);
  }
  void answer(int client, const std::string& request, const std::string& path) {
    {
      const std::lock_guard lock(mutex_);
      asked_.push_back(path);
    }
    Answer answer = handler_(path);
    while (answer.silent && !ended_) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (answer.silent) return;
    std::string head =
        "HTTP/1.1 " + std::to_string(answer.status) + " X\r\nConnection: close\r\nAccept-Ranges: bytes\r\n";
    const size_t range = request.find("Range: bytes=");
    if (range != std::string::npos && answer.status == 200) {
      const size_t whole = answer.body.size();
      const size_t begin = std::stoull(request.substr(range + 13));
      const size_t dash = request.find('-', range + 13);
      const size_t end = std::isdigit(static_cast<unsigned char>(request[dash + 1]))
                             ? std::min<size_t>(std::stoull(request.substr(dash + 1)), whole - 1)
                             : whole - 1;
      answer.body = begin < whole ? answer.body.substr(begin, end - begin + 1) : "";
      head = "HTTP/1.1 206 X\r\nConnection: close\r\nContent-Range: bytes " + std::to_string(begin) + "-" +
             std::to_string(end) + "/" + std::to_string(whole) + "\r\n";
    }
    head += "Content-Length: " + std::to_string(answer.body.size()) + "\r\n\r\n";
    if (!request.starts_with("HEAD")) head += answer.body;
    for (size_t sent = 0; sent < head.size();) {
      const ssize_t n = send(client, head.data() + sent, head.size() - sent, MSG_NOSIGNAL);
      if (n <= 0) return;
      sent += static_cast<size_t>(n);
    }
  }

  Handler handler_;
  int listener_, port_ = 0;
  std::atomic<bool> ended_{false};
  mutable std::mutex mutex_;
  std::vector<std::string> asked_;
  std::vector<std::thread> workers_;  // touched by thread_ until it has ended
  std::thread thread_;
};

}  // namespace nepho::test
